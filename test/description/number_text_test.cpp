#include "ellipsoid_vehicle_sim/description/number_text.h"

#include <gtest/gtest.h>

#include <clocale>

namespace ellipsoid_vehicle_sim {
namespace {

TEST(NumberText, ReadsWhatFilesHold) {
  EXPECT_EQ(parseNumber("0.25"), 0.25);
  EXPECT_EQ(parseNumber("  -3 \n"), -3.0);
  EXPECT_EQ(parseNumber(".001"), 0.001);
  EXPECT_EQ(parseNumber("5."), 5.0);
  EXPECT_EQ(parseNumber("+1E3"), 1000.0);
  EXPECT_EQ(parseNumber("-6.938893903907228e-18"), -6.938893903907228e-18);
}

TEST(NumberText, ReadsANumberTooSmallForADoubleAsNearlyZero) {
  const auto number = parseNumber("1e-400");
  ASSERT_TRUE(number);
  EXPECT_LE(*number, 5e-324);
}

TEST(NumberText, RefusesWhatIsNoFiniteDecimal) {
  for (const char* text : {"", " ", "1,5", "nan", "inf", "-inf", "NaN", "0x10", "1e999", "1.5m", "1e", "e5", ".", "--1",
                           "1 2", "1.2.3", "${r}", "1f", "٣"}) {
    EXPECT_FALSE(parseNumber(text)) << text;
  }
}

TEST(NumberText, ReadsListsPartedByRunsOfBlanks) {
  const auto numbers = parseNumberList("0                      -6.938893903907228e-18\t\n  1 ");
  ASSERT_TRUE(numbers);
  EXPECT_EQ(*numbers, (std::vector<double>{0.0, -6.938893903907228e-18, 1.0}));
  EXPECT_FALSE(parseNumberList("1 2 x"));
  EXPECT_TRUE(parseNumberList("")->empty());
}

TEST(NumberText, DoesNotFollowTheLocale) {
  // Where the machine has no such locale the claim holds trivially.
  const std::string before = std::setlocale(LC_ALL, nullptr);
  for (const char* locale : {"de_DE.UTF-8", "de_DE", "fr_FR.UTF-8"}) {
    if (std::setlocale(LC_ALL, locale)) break;
  }
  EXPECT_EQ(parseNumber("0.25"), 0.25);
  EXPECT_FALSE(parseNumber("0,25"));
  EXPECT_EQ(numberText(0.25), "0.25");
  std::setlocale(LC_ALL, before.c_str());
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
