#include "ellipsoid_vehicle_sim/sensors/ray_caster.h"

#ifdef WITH_EMBREE
#include <embree3/rtcore.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>
#endif

namespace ellipsoid_vehicle_sim {

#ifdef WITH_EMBREE

namespace {

/// Triangles as Embree's "user geometry": it gets boxes, and asks us about every triangle whose box a ray meets.
///
/// Floats. All that Embree sees is told from the middle of the world: coordinates up to E, its half diagonal, of which
/// a float loses E 2^-24. Corners of boxes, origin and direction of a ray that is first cut to the world, and the few
/// operations of a box test together lose less than 16 times that; boxes are wider by twice as much on every side.
constexpr double kWider = 32.0 * 0x1.0p-24;
/// Boxes wider than this part of the mean triangle would have many rays ask about many triangles in vain.
constexpr double kWidestPart = 0.25;

class EmbreeRayCaster : public RayCaster {
 public:
  EmbreeRayCaster(const Terrain& terrain, double wider, std::string description)
      : RayCaster(RayTracer::kEmbree, std::move(description)), middle_(terrain.bounds().center()), wider_(wider) {
    const Eigen::Vector3d more = Eigen::Vector3d::Constant(wider_);
    box_ = {terrain.bounds().min() - more, terrain.bounds().max() + more};
    for (int i = 0; i < terrain.triangleCount(); ++i) triangles_.push_back(terrain.triangle(i).v);
    // One thread: rays are shot from the caller's, and a short build is not worth threads that stay for ever.
    device_ = rtcNewDevice("threads=1");
    if (device_ == nullptr) return;
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(triangles_.size()));
    rtcSetGeometryUserData(geometry, this);
    rtcSetGeometryBoundsFunction(geometry, &EmbreeRayCaster::setBounds, this);
    rtcSetGeometryIntersectFunction(geometry, &EmbreeRayCaster::intersect);
    rtcCommitGeometry(geometry);
    scene_ = rtcNewScene(device_);
    // No box that a ray grazes may be lost to rounding.
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
    error_ = rtcGetDeviceError(device_);
  }
  ~EmbreeRayCaster() override {
    if (scene_ != nullptr) rtcReleaseScene(scene_);
    if (device_ != nullptr) rtcReleaseDevice(device_);
  }
  EmbreeRayCaster(const EmbreeRayCaster&) = delete;
  EmbreeRayCaster& operator=(const EmbreeRayCaster&) = delete;

  bool works() const { return device_ != nullptr && error_ == RTC_ERROR_NONE; }

  std::optional<RayHit> firstHit(const Ray& ray, double range) const override {
    const std::optional<RaySpan> span = raySpan(ray, box_, range);
    if (!span || !ray.origin.allFinite() || !ray.direction.allFinite()) return std::nullopt;
    Question question{{}, ShearedRay(ray), span->begin, range, std::nullopt};
    rtcInitIntersectContext(&question.context);
    RTCRayHit asked;
    const Eigen::Vector3f from = (ray.origin - middle_ + span->begin * ray.direction).cast<float>();
    const Eigen::Vector3f direction = ray.direction.cast<float>();
    asked.ray.org_x = from.x(), asked.ray.org_y = from.y(), asked.ray.org_z = from.z();
    asked.ray.dir_x = direction.x(), asked.ray.dir_y = direction.y(), asked.ray.dir_z = direction.z();
    asked.ray.tnear = 0.0f;
    asked.ray.tfar = reach(span->end - span->begin);
    asked.ray.time = 0.0f;
    asked.ray.mask = 0xffffffffu;
    asked.ray.id = 0;
    asked.ray.flags = 0;
    asked.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    asked.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &question.context, &asked);
    return question.first;
  }

 private:
  /// A ray on its way through Embree. The context stands first: that is all that comes back.
  struct Question {
    RTCIntersectContext context;
    ShearedRay ray;
    double begin, limit;
    std::optional<RayHit> first;
  };

  /// How far Embree has to look to miss nothing up to `distance` [m].
  float reach(double distance) const { return static_cast<float>((distance + wider_) * (1.0 + 0x1.0p-22)); }

  static void setBounds(const RTCBoundsFunctionArguments* arguments) {
    const auto& self = *static_cast<const EmbreeRayCaster*>(arguments->geometryUserPtr);
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& corner : self.triangles_[arguments->primID]) box.extend(corner);
    const Eigen::Vector3d more = Eigen::Vector3d::Constant(self.wider_);
    const Eigen::Vector3f low = (box.min() - self.middle_ - more).cast<float>();
    const Eigen::Vector3f high = (box.max() - self.middle_ + more).cast<float>();
    RTCBounds& bounds = *arguments->bounds_o;
    bounds.lower_x = low.x(), bounds.lower_y = low.y(), bounds.lower_z = low.z();
    bounds.upper_x = high.x(), bounds.upper_y = high.y(), bounds.upper_z = high.z();
  }

  static void intersect(const RTCIntersectFunctionNArguments* arguments) {
    if (arguments->valid[0] == 0) return;
    const auto& self = *static_cast<const EmbreeRayCaster*>(arguments->geometryUserPtr);
    Question& question = *reinterpret_cast<Question*>(arguments->context);
    const int i = static_cast<int>(arguments->primID);
    const auto& corners = self.triangles_[arguments->primID];
    const std::optional<double> t = question.ray.meets(corners[0], corners[1], corners[2]);
    if (!t || *t > question.limit) return;
    if (*t == question.limit && question.first && i > question.first->triangle) return;
    question.first = RayHit{*t, i};
    question.limit = *t;
    RTCRayHit& asked = *reinterpret_cast<RTCRayHit*>(arguments->rayhit);
    asked.ray.tfar = std::min(asked.ray.tfar, self.reach(*t - question.begin));
    asked.hit.geomID = 0;
  }

  std::vector<std::array<Eigen::Vector3d, 3>> triangles_;
  Eigen::Vector3d middle_;
  double wider_;
  Eigen::AlignedBox3d box_;
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
  RTCError error_ = RTC_ERROR_NONE;
};

/// Longest side of a triangle's box, the mean of all [m].
double meanSize(const Terrain& terrain) {
  double sum = 0.0;
  for (int i = 0; i < terrain.triangleCount(); ++i) {
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& corner : terrain.triangle(i).v) box.extend(corner);
    sum += box.sizes().maxCoeff();
  }
  return sum / terrain.triangleCount();
}

}  // namespace

std::unique_ptr<const RayCaster> makeEmbreeRayCaster(const Terrain& terrain, std::string& why) {
  const double wider = kWider * 0.5 * terrain.bounds().diagonal().norm(), size = meanSize(terrain);
  char text[160];
  if (wider > kWidestPart * size) {
    std::snprintf(text, sizeof text,
                  "Embree's floats are %.2g m fine in a world so large, its triangles measure %.2g m in the mean",
                  wider, size);
    why = text;
    return nullptr;
  }
  std::snprintf(text, sizeof text, "Embree %s, hits worked out in doubles", RTC_VERSION_STRING);
  auto caster = std::make_unique<EmbreeRayCaster>(terrain, wider, text);
  if (caster->works()) return caster;
  why = "Embree could not build its tree (no memory?)";
  return nullptr;
}

#else

std::unique_ptr<const RayCaster> makeEmbreeRayCaster(const Terrain&, std::string& why) {
  why = "built without Embree (libembree-dev), which is several times faster";
  return nullptr;
}

#endif

}  // namespace ellipsoid_vehicle_sim
