// urdf_doctor FILE: what the simulator makes of a URDF and what is wrong with it, without a ROS master.

#include <cmath>
#include <fstream>
#include <iostream>

#include "ellipsoid_vehicle_sim/description/joint_roles.h"
#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "ellipsoid_vehicle_sim/description/shipped_files.h"
#include "ellipsoid_vehicle_sim/description/urdf_loader.h"
#include "ellipsoid_vehicle_sim/description/urdf_writer.h"
#include "ellipsoid_vehicle_sim/description/xacro.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr int kProblems = 1, kBadUsage = 2;

constexpr const char* kUsage =
    "usage: urdf_doctor FILE [--json] [--write FILE] [--repair] [--forward WORD] [--body-ellipsoids N]\n"
    "                   [--package-dir DIR]... [--role JOINT=ROLE]...\n"
    "Tells what the simulator makes of a URDF (a path, or the name of a shipped vehicle): problems with line and what is\n"
    "allowed, masses and inertias that cannot be with a suggestion, what was assumed, each joint's role and why.\n"
    "  --json               the same as JSON\n"
    "  --write FILE         write it with repaired inertias and every collision as the ellipsoids that stand for it\n"
    "  --repair             read it as with repair_inertia: true\n"
    "  --forward WORD       auto, x, -x, y, -y\n"
    "  --body-ellipsoids N  for each shape of the body, at most; 1 to 64\n"
    "  --package-dir DIR    a folder searched for package://NAME/...; default: the file's and the three above it\n"
    "  --role JOINT=ROLE    as the parameter joint_roles\n"
    "exit code: 0 it loads and no inertia is at fault, 1 problems, 2 bad usage\n";

struct Arguments {
  std::string file, write, forward;
  std::vector<std::string> package_dirs, roles;
  int body_ellipsoids = 1;
  bool json = false, repair = false, help = false;
};

Loaded<Arguments> parse(int argc, char** argv) {
  Loaded<Arguments> result;
  Arguments a;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool takes_value = word == "--write" || word == "--forward" || word == "--body-ellipsoids" ||
                             word == "--package-dir" || word == "--role";
    if (takes_value && i + 1 >= argc) {
      result.problems.push_back({word, "needs a value"});
    } else if (word == "--write") {
      a.write = argv[++i];
    } else if (word == "--forward") {
      a.forward = argv[++i];
    } else if (word == "--package-dir") {
      a.package_dirs.emplace_back(argv[++i]);
    } else if (word == "--role") {
      a.roles.emplace_back(argv[++i]);
    } else if (word == "--body-ellipsoids") {
      const auto n = parseNumber(argv[++i]);
      if (!n || *n != std::floor(*n) || *n < 1.0 || *n > kMostBodyEllipsoids) {
        result.problems.push_back({word, std::string("'") + argv[i] + "' is no whole number from 1 to " +
                                             std::to_string(kMostBodyEllipsoids)});
      } else {
        a.body_ellipsoids = static_cast<int>(*n);
      }
    } else if (word == "--json") {
      a.json = true;
    } else if (word == "--repair") {
      a.repair = true;
    } else if (word == "--help" || word == "-h") {
      a.help = true;
    } else if (word.rfind("__", 0) == 0) {
      continue;  // roslaunch adds its remappings (__name:=, __log:=)
    } else if (word.rfind("-", 0) == 0) {
      result.problems.push_back({word, "is no option"});
    } else if (!a.file.empty()) {
      result.problems.push_back({word, "is a second file; one at a time"});
    } else {
      a.file = word;
    }
  }
  if (a.file.empty() && !a.help) result.problems.push_back({"FILE", "is missing"});
  if (result.problems.empty()) result.value = a;
  return result;
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out + "\"";
}

template <typename Items, typename Write>
std::string list(const Items& items, Write&& write) {
  std::string text = "[";
  for (std::size_t i = 0; i < items.size(); ++i) text += (i ? ",\n    " : "\n    ") + write(items[i]);
  return text + (items.empty() ? "]" : "\n  ]");
}

std::string number(double value) { return std::isfinite(value) ? numberText(value) : "null"; }

double massOf(const VehicleDescription& vehicle) {
  double mass = 0.0;
  for (const LinkDescription& link : vehicle.links) mass += link.mass;
  return mass;
}

std::string json(const std::string& file, const Loaded<VehicleDescription>& loaded,
                 const std::vector<InertiaFinding>& findings, bool healthy) {
  std::string text = "{\n  \"file\": " + quoted(file) + ",\n  \"loads\": " + (loaded ? "true" : "false") +
                     ",\n  \"healthy\": " + (healthy ? "true" : "false");
  text += ",\n  \"problems\": " + list(loaded.problems, [](const Problem& p) {
            return "{\"where\": " + quoted(p.where) + ", \"message\": " + quoted(p.message) + "}";
          });
  text += ",\n  \"inertia\": " + list(findings, [](const InertiaFinding& f) {
            return "{\"kind\": " + quoted(toString(f.kind)) + ", \"link\": " + quoted(f.link) +
                   ", \"line\": " + std::to_string(f.line) + ", \"fault\": " + (f.fault && !f.tolerated ? "true" : "false") +
                   ", \"message\": " + quoted(f.message) + ", \"suggestion\": " + quoted(f.suggestion) + "}";
          });
  text += ",\n  \"notes\": " + list(loaded.notes, [](const std::string& note) { return quoted(note); });
  if (loaded) {
    const VehicleDescription& v = *loaded.value;
    std::vector<const JointDescription*> movable;
    for (const JointDescription& joint : v.joints)
      if (joint.type != JointType::kFixed) movable.push_back(&joint);
    text += ",\n  \"name\": " + quoted(v.name) + ",\n  \"mass\": " + number(massOf(v)) +
            ",\n  \"layout\": " + quoted(toString(v.layout)) + ",\n  \"layout_text\": " + quoted(v.layout_text) +
            ",\n  \"forward_yaw\": " + number(v.forward_yaw);
    text += ",\n  \"joints\": " + list(movable, [](const JointDescription* joint) {
              return "{\"name\": " + quoted(joint->name) + ", \"line\": " + std::to_string(joint->line) +
                     ", \"role\": " + quoted(toString(joint->role)) + ", \"why\": " + quoted(joint->role_reason) + "}";
            });
    std::vector<std::pair<std::string, const EllipsoidDescription*>> ellipsoids;
    for (const LinkDescription& link : v.links)
      for (const EllipsoidDescription& e : link.ellipsoids) ellipsoids.emplace_back(link.name, &e);
    text += ",\n  \"ellipsoids\": " + list(ellipsoids, [](const auto& named) {
              const EllipsoidDescription& e = *named.second;
              return "{\"name\": " + quoted(e.name) + ", \"link\": " + quoted(named.first) + ", \"radii\": [" +
                     number(e.radii.x()) + ", " + number(e.radii.y()) + ", " + number(e.radii.z()) +
                     "], \"fit_error\": " + number(e.fit_error) + ", \"source\": " + quoted(e.source) + "}";
            });
  }
  return text + "\n}\n";
}

void print(const std::string& file, const Loaded<VehicleDescription>& loaded, bool healthy) {
  for (const Problem& p : loaded.problems) std::cout << "problem: " << p.text() << "\n";
  for (const std::string& note : loaded.notes) {
    const bool warning = note.rfind("WARNING ", 0) == 0;
    std::cout << (warning ? "warning: " : "note: ") << (warning ? note.substr(8) : note) << "\n";
  }
  if (!loaded) {
    std::cout << file << ": " << loaded.problems.size() << (loaded.problems.size() == 1 ? " problem" : " problems")
              << ", the simulator refuses it\n";
    return;
  }
  for (const std::string& line : jointTable(*loaded.value)) std::cout << line << "\n";
  std::cout << file << ": " << numberText(massOf(*loaded.value)) << " kg, "
            << (healthy ? "no inertia at fault" : "inertias at fault, taken as they are") << ", the simulator takes it\n";
}

int run(int argc, char** argv) {
  const Loaded<Arguments> parsed = parse(argc, argv);
  if (!parsed) {
    std::cerr << problemText(parsed.problems) << kUsage;
    return kBadUsage;
  }
  const Arguments& a = *parsed.value;
  if (a.help) {
    std::cout << kUsage;
    return 0;
  }
  const std::string share = shareFolderBesideProgram();
  const Loaded<std::string> found = findShipped(shippedVehicles(share), "vehicle", a.file, "FILE");
  Problems usage = found.problems;
  std::vector<InertiaFinding> findings;
  UrdfOptions options;
  options.roles = rolesFromWords(a.roles, "--role", usage);
  options.forward_yaw = forwardFromWord(a.forward, "--forward", usage);
  options.repair_inertia = a.repair;
  options.body_ellipsoids = a.body_ellipsoids;
  options.findings = &findings;
  if (!usage.empty()) {
    std::cerr << problemText(usage);
    return kBadUsage;
  }
  const std::string& file = *found.value;
  const UriResolver resolver = shippedResolver(a.package_dirs, file, share);
  const Loaded<VehicleDescription> loaded = loadUrdfFile(file, resolver, options);
  bool healthy = loaded.problems.empty();
  for (const InertiaFinding& f : findings) healthy = healthy && (!f.fault || a.repair);
  if (a.json) {
    std::cout << json(file, loaded, findings, healthy);
  } else {
    print(file, loaded, healthy);
  }
  if (!a.write.empty()) {
    options.repair_inertia = true;
    const Loaded<VehicleDescription> repaired = loadUrdfFile(file, resolver, options);
    const Loaded<std::string> text = readVehicleText(file);
    if (!repaired || !text) {
      std::cerr << "not written: " << (repaired ? problemText(text.problems) : problemText(repaired.problems));
      return kProblems;
    }
    std::ofstream out(a.write, std::ios::binary);
    out << canonicalUrdf(*text.value, *repaired.value, findings);
    out.close();
    if (!out) {
      std::cerr << a.write << ": cannot be written\n";
      return kProblems;
    }
    if (!a.json) std::cout << a.write << ": written\n";
  }
  return healthy ? 0 : kProblems;
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim

int main(int argc, char** argv) { return ellipsoid_vehicle_sim::run(argc, argv); }
