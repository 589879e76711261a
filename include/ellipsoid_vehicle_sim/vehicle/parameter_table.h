#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/vehicle/sim_config.h"

// Parameters by name: one table says key, type, unit, default, range and meaning. Readers (parameter server, scene
// files), the commented YAML manual and the reference pages are all made from it, so they cannot drift apart.

namespace ellipsoid_vehicle_sim {

/// A value as a parameter server, a YAML file or a command line has it. A whole number is welcome where a number is
/// asked.
using ParameterValue =
    std::variant<bool, std::int64_t, double, std::string, std::vector<double>, std::vector<std::string>>;
using ParameterValues = std::map<std::string, ParameterValue>;

enum class ParameterKind { kFlag, kNumber, kChoice, kText, kNumberList, kTextList };

/// What is known of a parameter besides where it is stored.
struct ParameterSpec {
  std::string key;
  ParameterKind kind = ParameterKind::kText;
  std::string unit;         ///< "" where there is none.
  std::string description;  ///< meaning and consequence, one or two sentences.
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
  std::vector<std::string> choices;  ///< kChoice only.
  std::size_t length = 0;            ///< of a kNumberList; 0: any.
  bool running = false;              ///< may change while the simulation runs.
  bool whole = false;                ///< a kNumber without a fraction.
  bool number_too = false;           ///< a kChoice that may also be a number between minimum and maximum.
};

/// One row: the spec, and how to write it into and read it from `Options`.
template <typename Options>
struct Parameter {
  ParameterSpec spec;
  std::function<void(Options&, const ParameterValue&)> set;          ///< only after refusal() found nothing.
  std::function<std::optional<ParameterValue>(const Options&)> get;  ///< nullopt: not given, derived at load.
};

template <typename Options>
using ParameterTable = std::vector<Parameter<Options>>;

/// "0.001 ... 0.1", "rk4 | semi_implicit_euler", "" for free text.
std::string rangeText(const ParameterSpec& spec);
/// The value as YAML reads it back, in its own type.
std::string valueText(const ParameterValue& value);
/// Why `value` cannot be taken; nullopt if it can.
std::optional<std::string> refusal(const ParameterSpec& spec, const ParameterValue& value);
/// The known word a misspelt one was probably meant to be; "" if none is near.
std::string closestWord(const std::string& word, const std::vector<std::string>& known);
/// One problem for each key of `values`, with the known key it resembles.
Problems unknownParameters(const ParameterValues& values, const std::vector<std::string>& known,
                           const std::string& where);
/// The manual's entry: comment lines, and `#key: default` to take the '#' away from.
std::string manualEntry(const ParameterSpec& spec, const std::optional<ParameterValue>& default_value);

/// The reference's row, in Markdown.
std::string referenceRow(const ParameterSpec& spec, const std::optional<ParameterValue>& default_value);

/// Every parameter of SimConfig.
ParameterTable<SimConfig> simConfigParameters();

/// Moves what the table knows from `values` into `options`; refused values are reported and leave the option as it was.
template <typename Options>
Problems takeParameters(const ParameterTable<Options>& table, const std::string& where, ParameterValues& values,
                        Options& options) {
  Problems problems;
  for (const Parameter<Options>& row : table) {
    const auto found = values.find(row.spec.key);
    if (found == values.end()) continue;
    if (const auto reason = refusal(row.spec, found->second)) {
      problems.push_back({where + row.spec.key, *reason});
    } else {
      row.set(options, found->second);
    }
    values.erase(found);
  }
  return problems;
}

template <typename Options>
std::vector<std::string> parameterKeys(const ParameterTable<Options>& table) {
  std::vector<std::string> keys;
  for (const Parameter<Options>& row : table) keys.push_back(row.spec.key);
  return keys;
}

// Rows by type of the member they fill.

/// A whole number or a real one; only for values refusal() has accepted.
inline double numberOf(const ParameterValue& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return static_cast<double>(*whole);
  return std::get<double>(value);
}

template <typename Options>
Parameter<Options> numberParameter(std::string key, std::string unit, double minimum, double maximum,
                                   double Options::*member, std::string description) {
  return {
      {std::move(key), ParameterKind::kNumber, std::move(unit), std::move(description), minimum, maximum, {}, 0, false},
      [member](Options& options, const ParameterValue& value) { options.*member = numberOf(value); },
      [member](const Options& options) -> std::optional<ParameterValue> { return options.*member; }};
}

template <typename Options>
Parameter<Options> numberParameter(std::string key, std::string unit, double minimum, double maximum,
                                   std::optional<double> Options::*member, std::string description) {
  return {
      {std::move(key), ParameterKind::kNumber, std::move(unit), std::move(description), minimum, maximum, {}, 0, false},
      [member](Options& options, const ParameterValue& value) { options.*member = numberOf(value); },
      [member](const Options& options) -> std::optional<ParameterValue> {
        if (!(options.*member)) return std::nullopt;
        return *(options.*member);
      }};
}

/// A number without a fraction.
template <typename Options>
Parameter<Options> wholeParameter(std::string key, std::string unit, double minimum, double maximum,
                                  double Options::*member, std::string description) {
  Parameter<Options> row =
      numberParameter(std::move(key), std::move(unit), minimum, maximum, member, std::move(description));
  row.spec.whole = true;
  return row;
}

/// A number inside a struct of the options.
template <typename Options, typename Inner>
Parameter<Options> nestedParameter(std::string key, std::string unit, double minimum, double maximum,
                                   Inner Options::*inner, double Inner::*member, std::string description) {
  return {
      {std::move(key), ParameterKind::kNumber, std::move(unit), std::move(description), minimum, maximum, {}, 0, false},
      [inner, member](Options& options, const ParameterValue& value) { (options.*inner).*member = numberOf(value); },
      [inner, member](const Options& options) -> std::optional<ParameterValue> { return (options.*inner).*member; }};
}

/// The same parameter, one that may change while the simulation runs.
template <typename Options>
Parameter<Options> running(Parameter<Options> parameter) {
  parameter.spec.running = true;
  return parameter;
}

template <typename Options>
Parameter<Options> flagParameter(std::string key, bool Options::*member, std::string description) {
  ParameterSpec spec;
  spec.key = std::move(key);
  spec.kind = ParameterKind::kFlag;
  spec.description = std::move(description);
  return {spec, [member](Options& options, const ParameterValue& value) { options.*member = std::get<bool>(value); },
          [member](const Options& options) -> std::optional<ParameterValue> { return options.*member; }};
}

template <typename Options, typename Choice>
Parameter<Options> choiceParameter(std::string key, std::vector<std::pair<std::string, Choice>> names,
                                   Choice Options::*member, std::string description) {
  ParameterSpec spec;
  spec.key = std::move(key);
  spec.kind = ParameterKind::kChoice;
  spec.description = std::move(description);
  for (const auto& name : names) spec.choices.push_back(name.first);
  return {spec,
          [member, names](Options& options, const ParameterValue& value) {
            for (const auto& name : names) {
              if (name.first == std::get<std::string>(value)) options.*member = name.second;
            }
          },
          [member, names](const Options& options) -> std::optional<ParameterValue> {
            for (const auto& name : names) {
              if (name.second == options.*member) return name.first;
            }
            return std::nullopt;
          }};
}

/// Text; an empty one counts as not given.
template <typename Options>
Parameter<Options> textParameter(std::string key, std::string Options::*member, std::string description) {
  ParameterSpec spec;
  spec.key = std::move(key);
  spec.kind = ParameterKind::kText;
  spec.description = std::move(description);
  return {spec,
          [member](Options& options, const ParameterValue& value) { options.*member = std::get<std::string>(value); },
          [member](const Options& options) -> std::optional<ParameterValue> {
            if ((options.*member).empty()) return std::nullopt;
            return options.*member;
          }};
}

/// A list of numbers or words; an empty one counts as not given.
template <typename Options, typename Item>
Parameter<Options> listParameter(std::string key, std::string unit, std::size_t length,
                                 std::vector<Item> Options::*member, std::string description) {
  ParameterSpec spec;
  spec.key = std::move(key);
  spec.kind = std::is_same_v<Item, double> ? ParameterKind::kNumberList : ParameterKind::kTextList;
  spec.unit = std::move(unit);
  spec.description = std::move(description);
  spec.length = length;
  return {
      spec,
      [member](Options& options, const ParameterValue& value) { options.*member = std::get<std::vector<Item>>(value); },
      [member](const Options& options) -> std::optional<ParameterValue> {
        if ((options.*member).empty()) return std::nullopt;
        return options.*member;
      }};
}

}  // namespace ellipsoid_vehicle_sim
