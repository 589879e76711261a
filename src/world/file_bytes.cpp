#include "ellipsoid_vehicle_sim/world/file_bytes.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace ellipsoid_vehicle_sim {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kHead = 64u << 10;

/// What stands at the path, if that is no file; empty if it is.
std::string otherThanFile(const fs::file_status& status) {
  switch (status.type()) {
    case fs::file_type::directory:
      return "folder";
    case fs::file_type::fifo:
      return "pipe";
    case fs::file_type::socket:
      return "socket";
    case fs::file_type::block:
    case fs::file_type::character:
      return "device";
    default:
      return fs::is_regular_file(status) ? "" : "something else";
  }
}

}  // namespace

Loaded<std::string> readFileBytes(const std::string& path, const std::string& what, std::uintmax_t most,
                                  const BytesWanted& wanted) {
  Loaded<std::string> result;
  const auto refuse = [&](const std::string& message) {
    result.problems.push_back({path, message});
    return result;
  };
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) {
    const bool absent = !error || error == std::errc::no_such_file_or_directory || error == std::errc::not_a_directory;
    return refuse(absent ? "there is no such file" : "cannot be opened: " + error.message());
  }
  const std::string other = otherThanFile(status);
  if (!other.empty()) return refuse("is a " + other + ", not a " + what + " file");
  std::ifstream file(path, std::ios::binary);
  if (!file) return refuse(std::string("cannot be opened: ") + std::strerror(errno));
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) return refuse("cannot be read: " + error.message());
  if (size > most)
    return refuse("has " + std::to_string(size) + " bytes; allowed for a " + what + " file are up to " + std::to_string(most));

  std::string bytes;
  const auto readUpTo = [&](std::uintmax_t end) {
    const std::size_t begin = bytes.size();
    bytes.resize(static_cast<std::size_t>(end));
    file.read(&bytes[begin], static_cast<std::streamsize>(bytes.size() - begin));
    bytes.resize(begin + static_cast<std::size_t>(file.gcount()));
    return bytes.size() == end;
  };
  bool complete = readUpTo(std::min(size, wanted ? kHead : size));
  if (wanted && complete) complete = readUpTo(std::clamp(wanted(bytes), std::uintmax_t{bytes.size()}, size));
  if (!complete)
    return refuse("could be read only up to byte " + std::to_string(bytes.size()) + " of " + std::to_string(size));
  result.value = std::move(bytes);
  return result;
}

}  // namespace ellipsoid_vehicle_sim
