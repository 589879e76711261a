#include "ellipsoid_vehicle_sim/description/inertia_check.h"

#include <Eigen/Eigenvalues>

#include "ellipsoid_vehicle_sim/description/number_text.h"

namespace ellipsoid_vehicle_sim {

std::string inertiaFault(const Eigen::Matrix3d& I_cm) {
  if (!I_cm.allFinite()) return "the inertia is not finite; allowed are finite numbers";
  const char* const names[3] = {"ixx", "iyy", "izz"};
  for (int i = 0; i < 3; ++i) {
    if (I_cm(i, i) <= 0.0) {
      return std::string(names[i]) + " reads " + numberText(I_cm(i, i)) +
             "; allowed is > 0, no body with mass turns for free";
    }
  }
  constexpr double kRounding = 1e-6;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(I_cm, Eigen::EigenvaluesOnly);
  const Eigen::Vector3d m = solver.eigenvalues();  // ascending
  const std::string moments =
      "the principal moments are " + numberText(m[0]) + ", " + numberText(m[1]) + ", " + numberText(m[2]);
  // Below the solver's own rounding a positive eigenvalue means nothing.
  if (m[0] <= 1e-14 * m[2]) return moments + "; allowed is all > 0 (the products of inertia are too large)";
  if (m[2] > (m[0] + m[1]) * (1.0 + kRounding)) {
    return moments + "; allowed is the largest <= the sum of the others, " + numberText(m[0] + m[1]) +
           ": no body has such an inertia";
  }
  return {};
}

}  // namespace ellipsoid_vehicle_sim
