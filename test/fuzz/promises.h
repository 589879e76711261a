#pragma once

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include "ellipsoid_vehicle_sim/vehicle/simulator.h"
#include "ellipsoid_vehicle_sim/world/mesh_file.h"
#include "support/meshes.h"

namespace ellipsoid_vehicle_sim::fuzz {

/// Ends the program, so that the fuzzer keeps the input, unless `kept`.
inline void promise(bool kept, const std::string& what) {
  if (kept) return;
  std::fprintf(stderr, "broken promise: %s\n", what.c_str());
  std::abort();
}

/// Problems say where and why.
inline void checkProblems(const Problems& problems) {
  for (const Problem& problem : problems) {
    promise(!problem.where.empty(), "a problem says where it is: " + problem.message);
    promise(!problem.message.empty(), "a problem says what it is, at " + problem.where);
  }
}

/// A value or problems, never both or neither.
template <typename T>
void checkLoaded(const Loaded<T>& loaded) {
  promise(loaded.value.has_value() == loaded.problems.empty(), "a value exactly when there are no problems");
  checkProblems(loaded.problems);
}

inline void checkMesh(const Loaded<MeshData>& mesh) {
  checkLoaded(mesh);
  if (!mesh) return;
  promise(!mesh.value->triangles.empty(), "a mesh has triangles");
  for (const auto& triangle : mesh.value->triangles) {
    for (const std::uint32_t v : triangle) {
      promise(v < mesh.value->vertices.size(), "an index leads to a vertex");
      promise(mesh.value->vertices[v].allFinite(), "a corner is finite");
    }
  }
}

inline std::shared_ptr<const Terrain> flatGround() {
  static const std::shared_ptr<const Terrain> ground = [] {
    TriangleSoup soup = flatSoup(4, 10.0);
    for (Eigen::Vector3d& v : soup.vertices) v -= Eigen::Vector3d(20.0, 20.0, 0.0);
    Loaded<Terrain> built = Terrain::build(std::move(soup));
    return std::make_shared<const Terrain>(std::move(*built.value));
  }();
  return ground;
}

/// Nothing that is published is NaN or infinite, frozen or not.
inline void checkFinite(const Simulator& simulator) {
  const Pose X_WR = simulator.rootPose();
  promise(X_WR.p.allFinite() && X_WR.q.coeffs().allFinite(), "the pose is finite");
  promise(simulator.rootVelocity_W().allFinite() && simulator.rootAngularVelocity_W().allFinite(),
          "the velocity is finite");
  std::vector<JointReading> joints;
  simulator.jointReadings(joints);
  for (const JointReading& joint : joints)
    promise(std::isfinite(joint.position) && std::isfinite(joint.velocity) && std::isfinite(joint.effort),
            "a joint's reading is finite");
  std::vector<ContactReport> contacts;
  simulator.contacts(contacts);
  for (const ContactReport& contact : contacts)
    promise(contact.p_WC.allFinite() && std::isfinite(contact.normal_force) && contact.friction_W.allFinite(),
            "a contact is finite");
  promise(std::isfinite(simulator.encoderSpeed()) && std::isfinite(simulator.encoderYawRate()), "encoders are finite");
}

}  // namespace ellipsoid_vehicle_sim::fuzz
