// Meshes, one target for each format: STL text and binary, OBJ, DAE. What can be read becomes a terrain.
#include "fuzz_target.h"
#include "promises.h"

namespace ellipsoid_vehicle_sim::fuzz {
namespace {

void fuzzMesh(const std::string& input, const char* name) {
  Loaded<MeshData> mesh = readMeshBytes(input, name);
  checkMesh(mesh);
  if (!mesh || mesh.value->triangles.size() > 2000) return;
  TriangleSoup soup;
  soup.vertices = std::move(mesh.value->vertices);
  soup.triangles = std::move(mesh.value->triangles);
  const Loaded<Terrain> terrain = Terrain::build(std::move(soup));
  checkLoaded(terrain);
  if (!terrain) return;
  const Eigen::Vector3d middle = terrain.value->bounds().center();
  for (const HeightHit& hit : terrain.value->heights(middle.x(), middle.y()))
    promise(std::isfinite(hit.z), "a height is finite");
  std::vector<int> found;
  terrain.value->query(terrain.value->bounds(), found);
  promise(static_cast<int>(found.size()) == terrain.value->triangleCount(), "its own box meets all of a terrain");
}

}  // namespace

void fuzzStl(const std::string& input) { fuzzMesh(input, "mesh.stl"); }
void fuzzObj(const std::string& input) { fuzzMesh(input, "mesh.obj"); }
void fuzzDae(const std::string& input) { fuzzMesh(input, "mesh.dae"); }

}  // namespace ellipsoid_vehicle_sim::fuzz
