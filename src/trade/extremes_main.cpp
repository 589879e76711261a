// extremes: runs the maps of extremes and writes them as a table; scripts/plot_extremes draws it.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <fstream>
#include <iostream>
#include <mutex>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "ellipsoid_vehicle_sim/scene/progress_bar.h"
#include "ellipsoid_vehicle_sim/trade/extremes.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr const char* kUsage =
    "usage: extremes [--ticks N] [--axis NAME]... [--integrator NAME]... [--jobs N] --out FILE.csv\n"
    "Runs small scenes with one quantity at an extreme, with every integrator at ticks from 1 us to 0.1 s, and writes what\n"
    "came of each: passive, refused, stopped, reported, gained (a failure).\n"
    "  --ticks N          ticks of a cell, at most; default 2000\n"
    "  --axis NAME        only this one; may be repeated; default: all\n"
    "  --integrator NAME  only this one; may be repeated; default: all\n"
    "  --jobs N           cells side by side; default: one for each core\n"
    "exit code: 0 no failure, 1 some, or FILE.csv cannot be written, 2 bad input\n";

constexpr double kTicks[] = {1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1};

struct Arguments {
  std::string out;
  int ticks = 2000, jobs = 1;
  std::vector<std::string> axes, integrators;
  bool help = false;
};

std::vector<std::string> axisNames() {
  std::vector<std::string> names;
  for (const ExtremeAxis& axis : extremeAxes()) names.push_back(axis.name);
  return names;
}

std::vector<std::string> integratorNames() {
  std::vector<std::string> names;
  for (int k = 0; k < kIntegratorCount; ++k) names.emplace_back(toString(static_cast<IntegratorKind>(k)));
  return names;
}

bool isAmong(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

Loaded<Arguments> parse(int argc, char** argv) {
  Loaded<Arguments> result;
  Arguments a;
  a.jobs = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const auto number = [&result](const std::string& word, const char* text, double most, int& value) {
    const std::optional<double> n = parseNumber(text);
    if (!n || !(*n >= 1.0 && *n <= most) || *n != std::floor(*n)) {
      result.problems.push_back({word, std::string("'") + text + "' is no whole number from 1 to " + numberText(most)});
    } else {
      value = static_cast<int>(*n);
    }
  };
  const auto name = [&result](const std::string& word, const std::string& text, const std::vector<std::string>& known,
                              std::vector<std::string>& names) {
    if (isAmong(known, text)) return names.push_back(text);
    std::string list;
    for (const std::string& k : known) list += (list.empty() ? "" : ", ") + k;
    result.problems.push_back({word, "'" + text + "' is none of " + list});
  };
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool takes_value = word == "--out" || word == "--ticks" || word == "--jobs" || word == "--axis" || word == "--integrator";
    if (takes_value && i + 1 >= argc) {
      result.problems.push_back({word, "needs a value"});
    } else if (word == "--out") {
      a.out = argv[++i];
    } else if (word == "--ticks") {
      number(word, argv[++i], 1e6, a.ticks);
    } else if (word == "--jobs") {
      number(word, argv[++i], 256.0, a.jobs);
    } else if (word == "--axis") {
      name(word, argv[++i], axisNames(), a.axes);
    } else if (word == "--integrator") {
      name(word, argv[++i], integratorNames(), a.integrators);
    } else if (word == "--help" || word == "-h") {
      a.help = true;
    } else if (word.rfind("__", 0) != 0) {  // roslaunch's own
      result.problems.push_back({word, "is no option; known are --ticks, --axis, --integrator, --jobs, --out, --help"});
    }
  }
  if (a.out.empty() && !a.help) result.problems.push_back({"--out", "is missing: the CSV file for the results"});
  if (result.problems.empty()) result.value = std::move(a);
  return result;
}

struct Cell {
  const ExtremeAxis* axis;
  ExtremeCell cell;
  ExtremeResult result;
};

std::vector<Cell> cellsOf(const Arguments& a) {
  std::vector<Cell> cells;
  for (const ExtremeAxis& axis : extremeAxes()) {
    if (!a.axes.empty() && !isAmong(a.axes, axis.name)) continue;
    for (const double value : axis.values)
      for (int k = 0; k < kIntegratorCount; ++k) {
        const auto integrator = static_cast<IntegratorKind>(k);
        if (!a.integrators.empty() && !isAmong(a.integrators, toString(integrator))) continue;
        for (const double dt : kTicks) cells.push_back({&axis, {axis.name, value, integrator, dt}, {}});
      }
  }
  return cells;
}

std::string lineOf(const Cell& c) {
  std::string cause = c.result.cause;
  for (char& letter : cause)
    if (letter == '"' || letter == '\n') letter = ' ';
  std::ostringstream line;
  line << c.axis->name << ',' << c.axis->unit << ',' << c.cell.value << ',' << toString(c.cell.integrator) << ',' << c.cell.dt
       << ',' << toString(c.result.outcome) << ',' << c.result.gain << ',' << c.result.bound << ',' << c.result.unaccounted << ',' << c.result.predicted << ",\"" << cause << "\"\n";
  return line.str();
}

int run(int argc, char** argv) {
  const Loaded<Arguments> parsed = parse(argc, argv);
  if (!parsed) {
    std::cerr << problemText(parsed.problems) << kUsage;
    return 2;
  }
  if (parsed.value->help) {
    std::cout << kUsage;
    return 0;
  }
  const Arguments& a = *parsed.value;
  std::ofstream table(a.out, std::ios::binary | std::ios::trunc);
  if (!table) {
    std::cerr << a.out << ": cannot be written\n";
    return 1;
  }
  std::vector<Cell> cells = cellsOf(a);
  ProgressBar bar("extremes");
  std::mutex mutex;
  std::atomic<std::size_t> next{0};
  std::size_t done = 0;
  const auto work = [&] {
    for (std::size_t i; (i = next++) < cells.size();) {
      cells[i].result = runExtreme(cells[i].cell, a.ticks);
      const std::lock_guard<std::mutex> lock(mutex);
      bar.show(static_cast<double>(++done) / static_cast<double>(cells.size()), cells[i].axis->name);
    }
  };
  std::vector<std::thread> threads;
  for (int j = 0; j < a.jobs; ++j) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  bar.finish();
  table << "axis,unit,value,integrator,dt,outcome,gain,bound,unaccounted,predicted_margin,cause\n";
  std::size_t gained = 0;
  for (const Cell& c : cells) {
    table << lineOf(c);
    gained += c.result.outcome == ExtremeOutcome::kGained ? 1 : 0;
  }
  table.close();
  if (!table) {
    std::cerr << a.out << ": cannot be written\n";
    return 1;
  }
  std::cout << cells.size() << " cells, " << gained << " gained energy: " << a.out << "\n";
  return gained == 0 ? 0 : 1;
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim

int main(int argc, char** argv) { return ellipsoid_vehicle_sim::run(argc, argv); }
