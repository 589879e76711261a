// Why not assimp 5.2: it rounds coordinates to float (half a metre in a national grid), says "index out of range"
// without a line, also when the fault is an unreadable vertex before it, and opens files the mesh names.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "mesh_readers.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr std::size_t kMostProblems = 20;

class ObjReader {
 public:
  ObjReader(const std::string& text, const std::string& path) : path_(path), words_(text) {}

  Loaded<MeshData> read() {
    do {
      line_ = words_.line();
      const std::string_view keyword = words_.wordOfLine();
      if (keyword.empty() || keyword[0] == '#') continue;
      if (keyword == "v") {
        readVertex();
      } else if (keyword == "f") {
        readFace();
      } else if (keyword == "l" || keyword == "p") {
        ++points_and_lines_;
      } else if (keyword == "mtllib") {
        checkMaterials();
      } else if (!isKnown(keyword)) {
        if (unknown_++ == 0) first_unknown_ = atLine(path_, line_) + ": " + inQuotes(keyword);
      }
      if (result_.problems.size() >= kMostProblems) break;
    } while (words_.nextLine());

    // Faces may name vertices that come later, so this is known only now.
    if (result_.problems.empty() && largest_index_ > static_cast<long>(mesh_.vertices.size())) {
      refuse(largest_index_line_, largest_index_);
    }
    if (!result_.problems.empty()) return std::move(result_);
    std::size_t begin = 0;
    PolygonCutter cutter;
    for (const std::size_t end : polygon_ends_) {
      cutter.append(mesh_.vertices, corners_.data() + begin, end - begin, mesh_.triangles);
      begin = end;
    }
    if (cutter.fanned() > 0) note(path_ + ": " + fannedNote(cutter.fanned()));
    if (points_and_lines_ > 0) note(path_ + ": " + std::to_string(points_and_lines_) + " points and lines ignored");
    if (unknown_ > 0) note(first_unknown_ + " is not known, ignored (" + std::to_string(unknown_) + " lines such)");
    result_.value = std::move(mesh_);
    return std::move(result_);
  }

 private:
  static bool isKnown(std::string_view keyword) {
    constexpr std::array<std::string_view, 16> kHarmless = {
        "vt",    "vn",       "vp",       "g",   "o",      "s",      "usemtl",     "mg",
        "bevel", "c_interp", "d_interp", "lod", "usemap", "maplib", "shadow_obj", "trace_obj"};
    return std::find(kHarmless.begin(), kHarmless.end(), keyword) != kHarmless.end();
  }

  void note(std::string text) { result_.notes.push_back(std::move(text)); }
  void problem(std::string message) { result_.problems.push_back({atLine(path_, line_), std::move(message)}); }
  void refuse(int line, long index) {
    result_.problems.push_back({atLine(path_, line), "face with vertex " + std::to_string(index) +
                                                         "; allowed are 1 to " + std::to_string(mesh_.vertices.size()) +
                                                         ", or negative ones counted back from here"});
  }

  void readVertex() {
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      const std::string_view word = words_.wordOfLine();
      const std::optional<double> value = numbers_.number(word);
      if (!value || !std::isfinite(*value)) {
        problem(word.empty() ? "vertex with " + std::to_string(k) + " coordinates; it needs 3"
                             : "vertex coordinate " + inQuotes(word) + " is not a finite number");
        break;
      }
      v[k] = *value;
    }
    mesh_.vertices.push_back(v);  // also after a problem, so that the indices still count right
  }

  void readFace() {
    const std::size_t begin = corners_.size();
    for (std::string_view word = words_.wordOfLine(); !word.empty(); word = words_.wordOfLine()) {
      const std::string_view first = word.substr(0, word.find('/'));  // vertex/texture/normal
      const std::optional<double> number = numbers_.number(first);
      if (!number || *number != std::trunc(*number) || std::abs(*number) > 4e9) {
        return problem("face corner " + inQuotes(word) + " is not a vertex number");
      }
      long index = static_cast<long>(*number);
      if (index < 0) index += static_cast<long>(mesh_.vertices.size()) + 1;
      if (index < 1) return refuse(line_, static_cast<long>(*number));
      if (index > largest_index_) largest_index_ = index, largest_index_line_ = line_;
      corners_.push_back(static_cast<std::uint32_t>(index - 1));
    }
    const std::size_t count = corners_.size() - begin;
    if (count < 3) return problem("face with " + std::to_string(count) + " corners; it needs 3");
    polygon_ends_.push_back(corners_.size());
  }

  void checkMaterials() {
    const std::string_view name = words_.wordOfLine();
    std::error_code error;
    if (std::filesystem::exists(std::filesystem::path(path_).parent_path() / name, error)) return;
    note(atLine(path_, line_) + ": material file " + inQuotes(name) + " is missing; only colours are lost");
  }

  const std::string& path_;
  WordReader words_;
  NumberReader numbers_;
  int line_ = 0;
  Loaded<MeshData> result_;
  MeshData mesh_;
  std::vector<std::uint32_t> corners_;     ///< of all polygons, one after the other
  std::vector<std::size_t> polygon_ends_;  ///< where in corners_ each of them ends
  long largest_index_ = 0;
  int largest_index_line_ = 0;
  std::size_t points_and_lines_ = 0, unknown_ = 0;
  std::string first_unknown_;
};

}  // namespace

Loaded<MeshData> readObj(const std::string& text, const std::string& path) { return ObjReader(text, path).read(); }

}  // namespace ellipsoid_vehicle_sim
