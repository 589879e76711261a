#include "ellipsoid_vehicle_sim/description/inertia_lint.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>

#include "support/temporary_files.h"
#include "urdf_samples.h"

namespace ellipsoid_vehicle_sim {
namespace {

std::string massText(double mass, double ixx, double iyy, double izz, const std::string& xyz = "0 0 0") {
  return "<inertial><origin xyz=\"" + xyz + "\"/><mass value=\"" + std::to_string(mass) + "\"/><inertia ixx=\"" +
         std::to_string(ixx) + "\" ixy=\"0\" ixz=\"0\" iyy=\"" + std::to_string(iyy) + "\" iyz=\"0\" izz=\"" +
         std::to_string(izz) + "\"/></inertial>\n";
}

/// A cart whose left wheel has this inertial; a cylinder of radius 0.1 m and half width 0.025 m about y.
std::string cartText(const std::string& wheel_inertial) {
  const std::string cylinder = collisionText("<cylinder radius=\"0.1\" length=\"0.05\"/>", "0 0 0", "1.5707963267948966 0 0");
  return linkText("base", inertialText(10.0) + collisionText("<box size=\"0.6 0.4 0.2\"/>", "0 0 0.1")) +
         linkText("l", wheel_inertial + cylinder) + jointText("l_axle", "continuous", "base", "l", "0 0.25 0", "0 1 0") +
         wheelText("r", "base", "0 -0.25 0") + wheelText("f", "base", "0.25 0 0");
}

Loaded<VehicleDescription> linted(const std::string& text, std::vector<InertiaFinding>& findings, bool repair = false) {
  UrdfOptions options;
  options.findings = &findings;
  options.repair_inertia = repair;
  return loadText(text, options);
}

const InertiaFinding* found(const std::vector<InertiaFinding>& findings, InertiaFinding::Kind kind, const std::string& link) {
  for (const InertiaFinding& f : findings)
    if (f.kind == kind && f.link == link) return &f;
  return nullptr;
}

// Of a cylinder of 2 kg: 1/2 m r^2 about its axis, m (r^2 / 4 + w^2 / 3) across it.
constexpr double kAlong = 0.5 * 2.0 * 0.01, kAcross = 2.0 * (0.01 / 4.0 + 0.025 * 0.025 / 3.0);

TEST(InertiaLint, ARightWheelHasNothingToTell) {
  std::vector<InertiaFinding> findings;
  const auto loaded = linted(cartText(massText(2.0, kAcross, kAlong, kAcross)), findings);
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_EQ(found(findings, InertiaFinding::Kind::kSpin, "l"), nullptr);
  EXPECT_EQ(found(findings, InertiaFinding::Kind::kBalance, "l"), nullptr);
}

TEST(InertiaLint, TheTriangleInequalityIsRefusedWithTheCylindersInertia) {
  std::vector<InertiaFinding> findings;
  const auto loaded = linted(cartText(massText(2.0, 0.003, 0.009, 0.003)), findings);
  EXPECT_TRUE(refusedWith(loaded, {"link 'l'", "principal moments", "suggested: <inertia ixx=\"0.00541667\"", "iyy=\"0.01\"",
                                   "repair_inertia: true"}));
  const auto repaired = linted(cartText(massText(2.0, 0.003, 0.009, 0.003)), findings, true);
  ASSERT_TRUE(isLoaded(repaired));
  EXPECT_NEAR(linkOf(*repaired.value, "l").I_cm_L(1, 1), kAlong, 1e-12);
  EXPECT_NEAR(linkOf(*repaired.value, "l").I_cm_L(0, 0), kAcross, 1e-12);
  EXPECT_TRUE(notedWith(repaired, {"link 'l'", "REPAIRED", "principal moments"}));
}

TEST(InertiaLint, NegativeAndIndefiniteInertiasLikewise) {
  std::vector<InertiaFinding> findings;
  EXPECT_TRUE(refusedWith(linted(cartText(massText(2.0, -0.003, 0.009, 0.003)), findings), {"ixx reads -0.003", "suggested"}));
  EXPECT_TRUE(isLoaded(linted(cartText(massText(2.0, -0.003, 0.009, 0.003)), findings, true)));
}

TEST(InertiaLint, MassesOfZeroAndBelowAreSuggestedAndRepaired) {
  std::vector<InertiaFinding> findings;
  EXPECT_TRUE(refusedWith(linted(cartText(""), findings), {"link 'l'", "weighs 0 kg", "suggested: <mass value="}));
  const auto weightless = linted(cartText(""), findings, true);
  ASSERT_TRUE(isLoaded(weightless));
  EXPECT_NEAR(linkOf(*weightless.value, "l").mass, 500.0 * M_PI * 0.01 * 0.05, 1e-9);
  const std::string negative = massText(-2.0, kAcross, kAlong, kAcross);
  EXPECT_TRUE(refusedWith(linted(cartText(negative), findings), {"<mass value=\"-2", "suggested: <mass value=\"2\"/>"}));
  const auto turned = linted(cartText(negative), findings, true);
  ASSERT_TRUE(isLoaded(turned));
  EXPECT_EQ(linkOf(*turned.value, "l").mass, 2.0);
}

TEST(InertiaLint, ARadiusOfGyrationBeyondTheShapeIsTold) {
  std::vector<InertiaFinding> findings;
  const auto large = linted(cartText(massText(2.0, 5.0, 5.0, 5.0)), findings);
  ASSERT_TRUE(isLoaded(large));
  ASSERT_TRUE(found(findings, InertiaFinding::Kind::kSize, "l"));
  EXPECT_TRUE(notedWith(large, {"WARNING", "link 'l'", "radius of gyration", "more than"}));
  const auto small = linted(cartText(massText(2.0, 1e-6, 1e-6, 1e-6)), findings);
  EXPECT_TRUE(notedWith(small, {"WARNING", "link 'l'", "less than a fiftieth"}));
}

TEST(InertiaLint, ADiscWithItsMomentOnTheWrongEntryIsTold) {
  std::vector<InertiaFinding> findings;
  const auto loaded = linted(cartText(massText(2.0, kAcross, kAcross, kAlong)), findings);
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_TRUE(notedWith(loaded, {"WARNING", "link 'l'", "on the wrong entry", "suggested: <inertia"}));
  const auto repaired = linted(cartText(massText(2.0, kAcross, kAcross, kAlong)), findings, true);
  EXPECT_NEAR(linkOf(*repaired.value, "l").I_cm_L(1, 1), kAlong, 1e-12);
}

TEST(InertiaLint, AWheelOutOfBalanceAndAVehicleBesideItsMiddleAreTold) {
  std::vector<InertiaFinding> findings;
  EXPECT_TRUE(notedWith(linted(cartText(massText(2.0, kAcross, kAlong, kAcross, "0.02 0 0")), findings),
                        {"WARNING", "link 'l'", "0.02 m off its axis", "suggested"}));
  const std::string ballast = linkText("ballast", massText(30.0, 0.1, 0.1, 0.1, "0 0.2 0")) +
                              jointText("b", "fixed", "base", "ballast", "0 0 0.1", "1 0 0");
  EXPECT_TRUE(notedWith(linted(cartText(massText(2.0, kAcross, kAlong, kAcross)) + ballast, findings),
                        {"WARNING", "link 'ballast'", "to the left of the middle", "adds most"}));
}

// A hook of impossible inertia fixed to the base, or held by a joint that holds: the whole can be.
TEST(InertiaLint, AFaultThatTheBodyAroundItMakesUpForIsAWarning) {
  std::vector<InertiaFinding> findings;
  const std::string right = massText(2.0, kAcross, kAlong, kAcross);
  for (const std::string& joint :
       {jointText("h", "fixed", "base", "hook", "0 0 0.1", "1 0 0"),
        jointText("h", "revolute", "base", "hook", "0 0 0.1", "0 0 1",
                  "<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>")}) {
    const auto loaded = linted(cartText(right) + linkText("hook", massText(0.1, 0.001, 0.001, 0.009)) + joint, findings);
    ASSERT_TRUE(isLoaded(loaded));
    EXPECT_TRUE(notedWith(loaded, {"WARNING", "link 'hook'", "taken as it is"}));
  }
}

// --- The program ----------------------------------------------------------------------------------------------------

int doctor(const std::string& arguments) {
  const int status = std::system((std::string(PROGRAM_DIR) + "/urdf_doctor " + arguments).c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::string contents(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

TEST(UrdfDoctor, ExitCodesTellHealthyProblemsAndUsage) {
  const TemporaryFiles files;
  const std::string good = files.write("good.urdf", robotText(cartText(massText(2.0, kAcross, kAlong, kAcross))));
  const std::string bad = files.write("bad.urdf", robotText(cartText(massText(2.0, 0.003, 0.009, 0.003))));
  const std::string out = files.folder("") + "/out.txt";
  EXPECT_EQ(doctor(good + " > " + out), 0);
  EXPECT_NE(contents(out).find("the simulator takes it"), std::string::npos) << contents(out);
  EXPECT_NE(contents(out).find("l_axle"), std::string::npos);
  EXPECT_EQ(doctor(bad + " > " + out), 1);
  EXPECT_NE(contents(out).find("bad.urdf:7 link 'l'"), std::string::npos) << contents(out);
  EXPECT_NE(contents(out).find("suggested: <inertia"), std::string::npos);
  EXPECT_EQ(doctor("--repair " + bad + " > " + out), 0);
  EXPECT_EQ(doctor("> " + out + " 2>&1"), 2);
  EXPECT_EQ(doctor("/no/such.urdf > " + out + " 2>&1"), 2);
  EXPECT_EQ(doctor("--body-ellipsoids 0 " + good + " > " + out + " 2>&1"), 2);
  EXPECT_EQ(doctor("--help > " + out), 0);
}

TEST(UrdfDoctor, JsonSaysTheSame) {
  const TemporaryFiles files;
  const std::string bad = files.write("bad.urdf", robotText(cartText(massText(2.0, 0.003, 0.009, 0.003))));
  const std::string out = files.folder("") + "/out.json";
  EXPECT_EQ(doctor("--json " + bad + " > " + out), 1);
  EXPECT_EQ(std::system(("/usr/bin/python3 -c \"import json,sys; d=json.load(open('" + out +
                         "')); assert not d['loads'] and d['problems'] and d['inertia'][0]['link']=='l' and "
                         "'ixx' in d['inertia'][0]['suggestion']\"")
                            .c_str()),
            0);
}

TEST(UrdfDoctor, WhatItWritesLoadsWithTheSameEllipsoidsAndRightInertias) {
  const TemporaryFiles files;
  const std::string bad = files.write("bad.urdf", robotText(cartText(massText(2.0, 0.003, 0.009, 0.003))));
  const std::string fixed = files.folder("") + "/fixed.urdf";
  EXPECT_EQ(doctor(bad + " --write " + fixed + " > /dev/null"), 1);
  std::vector<InertiaFinding> findings;
  UrdfOptions options;
  options.repair_inertia = true;
  const auto before = loadUrdfFile(bad, {}, options);
  const auto after = loadUrdfFile(fixed);
  ASSERT_TRUE(isLoaded(before));
  ASSERT_TRUE(isLoaded(after));
  ASSERT_EQ(after.value->links.size(), before.value->links.size());
  for (std::size_t l = 0; l < before.value->links.size(); ++l) {
    const LinkDescription &a = before.value->links[l], &b = after.value->links[l];
    ASSERT_EQ(a.ellipsoids.size(), b.ellipsoids.size()) << a.name;
    EXPECT_TRUE(a.I_cm_L.isApprox(b.I_cm_L, 1e-9)) << a.name;
    for (std::size_t i = 0; i < a.ellipsoids.size(); ++i) {
      EXPECT_LT((a.ellipsoids[i].radii - b.ellipsoids[i].radii).norm(), 1e-9) << a.name;
      EXPECT_LT((a.ellipsoids[i].X_LE.p - b.ellipsoids[i].X_LE.p).norm(), 1e-9) << a.name;
    }
  }
  EXPECT_EQ(doctor(fixed + " > /dev/null"), 0);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
