#include "ellipsoid_vehicle_sim/description/parameter_file.h"

#include <fstream>
#include <sstream>

#include "ellipsoid_vehicle_sim/description/yaml_reader.h"

namespace ellipsoid_vehicle_sim {

Loaded<ParameterValues> readParameterFile(const std::string& path) {
  Loaded<ParameterValues> result;
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) {
    result.problems.push_back({path, "the file cannot be read"});
    return result;
  }
  ParameterValues values;
  try {
    const YAML::Node root = YAML::Load(text.str());
    if (!root.IsNull() && !root.IsMap()) {
      result.problems.push_back({path, "holds no 'key: value' pairs"});
      return result;
    }
    for (const auto& pair : root) {
      const std::string key = pair.first.Scalar();
      const std::string where = path + ":" + std::to_string(pair.first.Mark().line + 1) + " " + key;
      const auto value = parameterValue(pair.second);
      if (!value) {
        result.problems.push_back({where, "is empty, a dictionary or a mixed list, which no parameter is"});
      } else if (!values.emplace(key, *value).second) {
        result.problems.push_back({where, "is given twice"});
      }
    }
  } catch (const YAML::Exception& error) {
    result.problems.push_back({path + ":" + std::to_string(error.mark.line + 1), "no YAML: " + error.msg});
  }
  if (result.problems.empty()) result.value = std::move(values);
  return result;
}

}  // namespace ellipsoid_vehicle_sim
