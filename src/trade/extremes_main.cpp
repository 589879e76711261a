// extremes: runs the maps of extremes and writes them as a table; scripts/plot_extremes draws it.

#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>

#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "ellipsoid_vehicle_sim/scene/progress_bar.h"
#include "ellipsoid_vehicle_sim/trade/extremes.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr const char* kUsage =
    "usage: extremes [--ticks N] --out FILE.csv\n"
    "Runs small scenes with one quantity at an extreme, with every integrator at ticks from 1 us to 0.1 s, and writes what\n"
    "came of each: passive, refused, stopped, reported, gained (a failure). exit code: 0 no failure, 1 some, 2 bad input\n";

constexpr double kTicks[] = {1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1};

int run(int argc, char** argv) {
  std::string out;
  int ticks = 2000;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--out" && i + 1 < argc) {
      out = argv[++i];
    } else if (word == "--ticks" && i + 1 < argc) {
      const auto n = parseNumber(argv[++i]);
      if (!n || !(*n >= 1.0 && *n <= 1e6)) {
        std::cerr << "--ticks: '" << argv[i] << "' is no number from 1 to 1e6\n";
        return 2;
      }
      ticks = static_cast<int>(*n);
    } else {
      std::cerr << kUsage;
      return word == "--help" || word == "-h" ? 0 : 2;
    }
  }
  if (out.empty()) {
    std::cerr << "--out is missing\n" << kUsage;
    return 2;
  }
  std::ofstream table(out, std::ios::binary | std::ios::trunc);
  table << "axis,unit,value,integrator,dt,outcome,gain,predicted_margin,cause\n";
  std::size_t cells = 0, done = 0;
  for (const ExtremeAxis& axis : extremeAxes()) cells += axis.values.size() * kIntegratorCount * std::size(kTicks);
  ProgressBar bar("extremes");
  int gained = 0;
  for (const ExtremeAxis& axis : extremeAxes())
    for (const double value : axis.values)
      for (int k = 0; k < kIntegratorCount; ++k)
        for (const double dt : kTicks) {
          const ExtremeCell cell{axis.name, value, static_cast<IntegratorKind>(k), dt};
          const ExtremeResult result = runExtreme(cell, ticks);
          std::string cause = result.cause;
          for (char& c : cause)
            if (c == '"' || c == '\n') c = ' ';
          table << axis.name << ',' << axis.unit << ',' << value << ',' << toString(cell.integrator) << ',' << dt << ','
                << toString(result.outcome) << ',' << result.gain << ',' << result.predicted << ",\"" << cause << "\"\n";
          gained += result.outcome == ExtremeOutcome::kGained ? 1 : 0;
          bar.show(static_cast<double>(++done) / static_cast<double>(cells), axis.name);
        }
  bar.finish();
  table.close();
  if (!table) {
    std::cerr << out << ": cannot be written\n";
    return 1;
  }
  std::cout << cells << " cells, " << gained << " gained energy: " << out << "\n";
  return gained == 0 ? 0 : 1;
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim

int main(int argc, char** argv) { return ellipsoid_vehicle_sim::run(argc, argv); }
