#pragma once

#include <string>
#include <vector>

namespace ellipsoid_vehicle_sim::fuzz {

/// One way in for input from outside: takes any bytes, and ends the program (or throws) where they get the better of it. It
/// checks what is promised of every input: a value or a problem that says where and why, and never a value that is not
/// finite or leads nowhere.
struct Target {
  std::string name;
  void (*run)(const std::string& input);
};

/// All of them, by name.
const std::vector<Target>& targets();

void fuzzUrdf(const std::string& input);
void fuzzXacro(const std::string& input);
void fuzzStl(const std::string& input);
void fuzzObj(const std::string& input);
void fuzzDae(const std::string& input);
void fuzzWorld(const std::string& input);
void fuzzScene(const std::string& input);
void fuzzParameters(const std::string& input);
void fuzzCommands(const std::string& input);
void fuzzSnapshot(const std::string& input);

}  // namespace ellipsoid_vehicle_sim::fuzz
