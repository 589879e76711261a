#include "ellipsoid_vehicle_sim/description/parameter_file.h"

#include "ellipsoid_vehicle_sim/description/yaml_reader.h"
#include "ellipsoid_vehicle_sim/world/file_bytes.h"

namespace ellipsoid_vehicle_sim {

Loaded<ParameterValues> readParameterFile(const std::string& path) {
  const Loaded<std::string> text = readFileBytes(path, "parameter", kLargestYamlFile);
  if (text) return readParameterText(*text.value, path);
  Loaded<ParameterValues> result;
  result.problems = text.problems;
  return result;
}

Loaded<ParameterValues> readParameterText(const std::string& text, const std::string& path) {
  Loaded<ParameterValues> result;
  if (text.size() > kLargestYamlFile) {
    result.problems.push_back({path, "is larger than any parameters are"});
    return result;
  }
  const Loaded<YAML::Node> parsed = parseYaml(text, path);
  result.problems = parsed.problems;
  if (!parsed) return result;
  const YAML::Node& root = *parsed.value;
  if (!root.IsNull() && !root.IsMap()) {
    result.problems.push_back({path, "holds no 'key: value' pairs"});
    return result;
  }
  ParameterValues values;
  const auto take = [&](const std::string& key, const YAML::Node& name, const YAML::Node& node, const char* fault) {
    const std::string where = path + ":" + std::to_string(name.Mark().line + 1) + " " + key;
    const auto value = parameterValue(node);
    if (!value) {
      result.problems.push_back({where, fault});
    } else if (!values.emplace(key, *value).second) {
      result.problems.push_back({where, "is given twice"});
    }
  };
  for (const auto& pair : root) {
    const std::string key = pair.first.Scalar();
    if (!pair.second.IsMap()) {
      take(key, pair.first, pair.second, "is empty or a mixed list, which no parameter is");
      continue;
    }
    // What stands in a dictionary has the key "DICTIONARY/key".
    for (const auto& inner : pair.second)
      take(key + "/" + inner.first.Scalar(), inner.first, inner.second,
           "is empty, a dictionary or a mixed list, which no parameter is");
  }
  if (result.problems.empty()) result.value = std::move(values);
  return result;
}

}  // namespace ellipsoid_vehicle_sim
