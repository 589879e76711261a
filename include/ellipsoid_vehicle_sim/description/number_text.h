#pragma once

#include <optional>
#include <string>
#include <vector>

namespace ellipsoid_vehicle_sim {

/// Numbers as XML attributes carry them, whatever the locale: decimal digits with a point and an exponent if need be.
/// "1,5", "nan", "inf", "0x10", "1e999" and anything left over are no numbers; 1e-18 and 1e-400 are.
std::optional<double> parseNumber(const std::string& text);

/// The numbers of a list parted by runs of blanks, tabs or line ends; nullopt as soon as one of them is none.
std::optional<std::vector<double>> parseNumberList(const std::string& text);

/// A number as messages show it: the shortest decimal that tells it apart from what a reader would type.
std::string numberText(double value);

}  // namespace ellipsoid_vehicle_sim
