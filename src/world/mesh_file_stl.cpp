// Why not assimp 5.2: it refuses a binary file with bytes after its triangles (or finds no triangle in it, without a
// word, when the header says "solid"), text in capitals or after a blank line; it drops a loop's fourth corner
// silently; and it rounds the numbers of text files to float.
#include <algorithm>
#include <cctype>
#include <cstring>
#include <limits>

#include "mesh_readers.h"
#include "vertex_welder.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr std::size_t kHeader = 84, kFacet = 50;
constexpr std::uint64_t kReadBehind = 1u << 20;  // of what follows the triangles, to tell how much it is
constexpr std::uint64_t kMostTriangles = 0xffffffffu / 3u;

/// Little-endian, whatever the machine is.
std::uint32_t unsignedAt(const std::string& text, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t k = 4; k-- > 0;) value = (value << 8) | static_cast<unsigned char>(text[at + k]);
  return value;
}

float floatAt(const std::string& text, std::size_t at) {
  const std::uint32_t bits = unsignedAt(text, at);
  float value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

bool isWord(std::string_view word, const char* lower_case) {
  return word.size() == std::strlen(lower_case) && std::equal(word.begin(), word.end(), lower_case, [](char a, char b) {
           return std::tolower(static_cast<unsigned char>(a)) == b;
         });
}

/// Begins with the word "solid" and holds nothing at its start that a text would not.
bool looksLikeText(const std::string& text) {
  WordReader words(text);
  const std::string_view first = words.word();
  return isWord(first.substr(0, 5), "solid") && text.substr(0, 1024).find('\0') == std::string::npos;
}

Loaded<MeshData> readBinary(const std::string& text, const std::string& path) {
  Loaded<MeshData> result;
  if (text.size() < kHeader) {
    result.problems.push_back({path, "neither a text STL (those begin with 'solid') nor a binary one: " +
                                         std::to_string(text.size()) + " bytes, the header alone has 84"});
    return result;
  }
  const std::uint64_t announced = unsignedAt(text, 80);
  const std::uint64_t held = (text.size() - kHeader) / kFacet;
  if (announced > held || announced > kMostTriangles) {
    result.problems.push_back({path, "binary STL announces " + std::to_string(announced) + " triangles (" +
                                         std::to_string(kHeader + kFacet * announced) + " bytes) but the file has " +
                                         std::to_string(text.size()) + " bytes, enough for " + std::to_string(held) +
                                         ": cut off, or not an STL file"});
    return result;
  }
  if (text.size() != kHeader + kFacet * announced) {
    const std::uint64_t behind = text.size() - kHeader - kFacet * announced;
    result.notes.push_back(path + ": " + (behind < kReadBehind ? "" : "at least ") + std::to_string(behind) +
                           " bytes after the last triangle ignored");
  }
  MeshData mesh;
  mesh.triangles.reserve(announced);
  VertexWelder welder(mesh.vertices);
  for (std::uint32_t i = 0; i < announced; ++i) {
    const std::size_t corners = kHeader + kFacet * i + 12;  // after the normal, which follows from the corners
    std::array<std::uint32_t, 3> triangle;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t at = corners + 12 * k;
      triangle[k] = welder.numberOf({floatAt(text, at), floatAt(text, at + 4), floatAt(text, at + 8)});
    }
    mesh.triangles.push_back(triangle);
  }
  result.value = std::move(mesh);
  return result;
}

Loaded<MeshData> readText(const std::string& text, const std::string& path) {
  Loaded<MeshData> result;
  MeshData mesh;
  NumberReader numbers;
  WordReader words(text);
  std::string_view word = words.word();
  bool in_loop = false, closed = false;
  VertexWelder welder(mesh.vertices);
  std::array<std::uint32_t, 3> triangle;
  std::size_t corners = 0;
  const auto refuse = [&](const std::string& message) {
    result.problems.push_back({atLine(path, words.line()), message});
    return result;
  };
  for (; !word.empty(); word = words.word()) {
    if (isWord(word, "solid") || isWord(word, "endsolid")) {
      if (in_loop) return refuse("'solid' or 'endsolid' inside a facet");
      closed = isWord(word, "endsolid");
      words.nextLine();  // the rest is a name
    } else if (isWord(word, "vertex")) {
      Eigen::Vector3d v;
      for (int k = 0; k < 3; ++k) {
        const std::string_view coordinate = words.word();
        const std::optional<double> value = numbers.number(coordinate);
        if (coordinate.empty()) return refuse("the file ends inside a facet: cut off");
        if (!value) return refuse("vertex coordinate " + inQuotes(coordinate) + " is not a number");
        v[k] = *value;
      }
      if (!in_loop) return refuse("vertex outside of a facet's loop");
      const std::uint32_t number = welder.numberOf(v);
      if (corners < 3) triangle[corners] = number;
      ++corners;
    } else if (isWord(word, "outer")) {
      in_loop = true;
      corners = 0;
    } else if (isWord(word, "endloop")) {
      if (!in_loop || corners != 3) return refuse("facet with " + std::to_string(corners) + " corners; allowed is 3");
      in_loop = false;
      mesh.triangles.push_back(triangle);
    } else if (isWord(word, "facet")) {
      words.word();  // "normal"; it follows from the corners
      for (int k = 0; k < 3; ++k) words.word();
    } else if (!isWord(word, "loop") && !isWord(word, "endfacet")) {
      return refuse(inQuotes(word) + " is not a word of a text STL");
    }
  }
  if (in_loop) return refuse("the file ends inside a facet: cut off");
  if (!closed) result.notes.push_back(path + ": no 'endsolid' at the end, the file may be cut off");
  result.value = std::move(mesh);
  return result;
}

}  // namespace

std::uintmax_t bytesOfStl(const std::string& head) {
  if (looksLikeText(head) || head.size() < kHeader) return std::numeric_limits<std::uintmax_t>::max();
  return kHeader + kFacet * std::uintmax_t{unsignedAt(head, 80)} + kReadBehind;
}

Loaded<MeshData> readStl(const std::string& text, const std::string& path) {
  const bool fits = text.size() >= kHeader && text.size() == kHeader + kFacet * std::uint64_t{unsignedAt(text, 80)};
  return !fits && looksLikeText(text) ? readText(text, path) : readBinary(text, path);
}

}  // namespace ellipsoid_vehicle_sim
