#include <openssl/evp.h>
#include <yaml-cpp/yaml.h>

#include <array>
#include <memory>

#include "build_info.inc"
#include "ellipsoid_vehicle_sim/scene/run_record.h"
#include "ellipsoid_vehicle_sim/vehicle/parameter_table.h"

namespace ellipsoid_vehicle_sim {

BuildInfo buildInfo() { return {BUILD_INFO_VERSION, BUILD_INFO_COMMIT, BUILD_INFO_COMPILER, BUILD_INFO_FLAGS}; }

std::string machineName() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    const std::size_t colon = line.find(": ");
    if (line.rfind("model name", 0) == 0 && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

std::optional<std::string> fileHash(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  if (!in || !context || EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr) != 1) return std::nullopt;
  std::array<char, 65536> buffer;
  while (in.read(buffer.data(), buffer.size()) || in.gcount() > 0)
    if (EVP_DigestUpdate(context.get(), buffer.data(), static_cast<std::size_t>(in.gcount())) != 1) return std::nullopt;
  if (!in.eof()) return std::nullopt;
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
  unsigned length = 0;
  if (EVP_DigestFinal_ex(context.get(), digest.data(), &length) != 1) return std::nullopt;
  std::string text;
  for (unsigned i = 0; i < length; ++i) {
    constexpr const char* kHex = "0123456789abcdef";
    text += kHex[digest[i] >> 4];
    text += kHex[digest[i] & 15];
  }
  return text;
}

Problems writeManifest(const std::string& path, const RunManifest& manifest, const Simulator& simulator) {
  const BuildInfo build = buildInfo();
  YAML::Emitter yaml;
  const auto pair = [&yaml](const std::string& key, const std::string& value) {
    yaml << YAML::Key << key << YAML::Value << YAML::DoubleQuoted << value;
  };
  yaml << YAML::BeginMap;
  pair("program", manifest.program);
  pair("result", manifest.result);
  pair("version", build.version);
  pair("commit", build.commit);
  pair("compiler", build.compiler);
  pair("flags", build.flags);
  pair("machine", machineName());
  yaml << YAML::Key << "seed" << YAML::Value;
  if (manifest.seed) {
    yaml << *manifest.seed;
  } else {
    yaml << YAML::Null;
  }
  pair("vehicle", simulator.model().description.name);
  yaml << YAML::Key << "unstable" << YAML::Value << simulator.isBeyondCertificate();
  yaml << YAML::Key << "triangles" << YAML::Value << simulator.terrain().triangleCount();
  for (const auto& [key, value] : manifest.more) pair(key, value);

  // What is derived at load has no value here; the load report below says what it became.
  yaml << YAML::Key << "parameters" << YAML::Value << YAML::BeginMap;
  for (const auto& row : simConfigParameters())
    if (const auto value = row.get(simulator.config()))
      yaml << YAML::Key << row.spec.key << YAML::Value << YAML::Load(valueText(*value));
  yaml << YAML::EndMap;

  yaml << YAML::Key << "files" << YAML::Value << YAML::BeginSeq;
  for (const std::string& file : manifest.files) {
    yaml << YAML::BeginMap;
    pair("path", file);
    pair("sha256", fileHash(file).value_or("cannot be read"));
    yaml << YAML::EndMap;
  }
  yaml << YAML::EndSeq;
  yaml << YAML::Key << "load_report" << YAML::Value << YAML::BeginSeq;
  for (const std::string& line : simulator.loadReport()) yaml << YAML::DoubleQuoted << line;
  yaml << YAML::EndSeq << YAML::EndMap;

  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out << yaml.c_str() << "\n";
  out.close();
  if (out) return {};
  return {{path, "cannot be written"}};
}

}  // namespace ellipsoid_vehicle_sim
