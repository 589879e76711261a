#pragma once

namespace ellipsoid_vehicle_sim {

/// Dormand-Prince 5(4) [Hairer1993, table II.5.2]: seven stages, a solution of order 5 and beside it one of order 4; their
/// difference estimates what the step gets wrong.
namespace dormand_prince {

constexpr int kStages = 7;
/// Smallest step of the error control within a tick, in parts of it: a touch-down is a jump that no step resolves.
constexpr double kSmallestPart = 1.0 / 1024.0;
constexpr double kNodes[kStages] = {0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0};
/// Row i: the weights of stages 0 ... i-1 that lead to stage i. The last row is the solution of order 5.
constexpr double kWeights[kStages][kStages] = {
    {},
    {1.0 / 5.0},
    {3.0 / 40.0, 9.0 / 40.0},
    {44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0},
    {19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0},
    {9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0},
    {35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0}};
/// Order 5 less order 4.
constexpr double kErrorWeights[kStages] = {
    71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0};

}  // namespace dormand_prince

/// One step from x over h into `result`, as a Runge-Kutta-Munthe-Kaas method on rotations [MuntheKaas1999]; `sum` becomes
/// the mean rate of the step, `error` that of the difference of the two solutions. Besides what integrator.h asks of a
/// System:
///   void weightedSum(const double* weights, const Rate* k, int n, Rate& sum)     sum = w0 k0 + ... + w(n-1) k(n-1)
template <typename System>
void dormandPrinceStep(System& system, const typename System::State& x, double h,
                       typename System::Rate (&k)[dormand_prince::kStages], typename System::Rate& sum,
                       typename System::Rate& error, typename System::State& result) {
  using namespace dormand_prince;
  system.rate(x, 0.0, k[0]);
  for (int i = 1; i < kStages; ++i) {
    system.weightedSum(kWeights[i], k, i, sum);
    system.advance(x, h, sum, result);
    system.rate(result, kNodes[i], k[i]);
    system.toTangent(h, sum, k[i]);
  }
  system.weightedSum(kErrorWeights, k, kStages, error);
}

}  // namespace ellipsoid_vehicle_sim
