#include "contact_events.h"

namespace ellipsoid_vehicle_sim {
namespace {

std::uint64_t bitOf(int ellipsoid) { return std::uint64_t{1} << (ellipsoid & 63); }

}  // namespace

// A bit for each ellipsoid; more than 64 share bits, and a change of one may then hide that of another.
std::uint64_t TickStepper::pressing() const {
  std::uint64_t mask = 0;
  for (const ActiveContact& active : dynamics_.activeContacts())
    if (active.force.normal > 0.0) mask |= bitOf(active.ellipsoid);
  return mask;
}

void TickStepper::noteContacts(const Motion& x) {
  pressed_ = pressing();
  for (const ActiveContact& active : dynamics_.activeContacts())
    start_touch_[static_cast<std::size_t>(active.ellipsoid)] = touchOf(x, active.ellipsoid);
}

bool TickStepper::pressedAtStart(int ellipsoid) const { return (pressed_ & bitOf(ellipsoid)) != 0; }

int TickStepper::firstChanged() const {
  const std::uint64_t changed = pressing() ^ pressed_;
  if (changed == 0) return -1;
  int e = 0;
  while ((changed & bitOf(e)) == 0) ++e;
  return e;
}

Touch TickStepper::touchOf(const Motion& x, int ellipsoid) const {
  Touch touch;
  for (const ActiveContact& active : dynamics_.activeContacts()) {
    if (active.ellipsoid != ellipsoid || (touch.known && active.contact.pressed <= touch.depth)) continue;
    const ContactLaw& law = model_.ellipsoids[ellipsoid].law;
    touch.known = true;
    touch.depth = active.contact.pressed;
    touch.speed = dynamics_.sinkingSpeed(x, active);
    touch.push = touch.depth + law.damping / law.stiffness * touch.speed;
  }
  return touch;
}

}  // namespace ellipsoid_vehicle_sim
