#include "explain_contact.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace ellipsoid_vehicle_sim {
namespace {

constexpr double kMillimetre = 1e-3;
// Contacts of two triangles that share the edge or corner they touch at differ by rounding [m].
constexpr double kSameContact = 1e-9;

std::string words(const char* format, double a = 0.0, double b = 0.0) {
  char text[240];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

const char* featureWord(Feature feature) {
  if (feature == Feature::kFace) return "its face";
  if (feature >= Feature::kVertex0) return "a corner";
  return "an edge";
}

/// A world of this triangle alone, as the contact search sees it.
Terrain onlyTriangle(const Triangle& triangle) {
  TriangleSoup soup;
  soup.vertices.assign(triangle.v.begin(), triangle.v.end());
  soup.triangles = {{0, 1, 2}};
  soup.surface = {0};
  soup.surfaces = {Surface{}};
  return std::move(*Terrain::build(std::move(soup)).value);
}

/// The memory with this triangle as number 0, and no other by its number.
ContactMemory renumbered(ContactMemory memory, int triangle) {
  for (CarriedContact& carried : memory.carried) carried.triangle = carried.triangle == triangle ? 0 : -1;
  return memory;
}

bool isSame(const TriangleContact& a, const TriangleContact& b) {
  return std::abs(a.depth - b.depth) <= kSameContact && (a.nhat_W - b.nhat_W).norm() <= 1e-6;
}

std::string reasonOf(const CandidateReport& candidate, double centre_height, const CandidateReport* winner,
                     double margin) {
  const TriangleContact& contact = candidate.alone;
  if (candidate.rank == 0) {
    const std::string why = std::isfinite(margin) ? words("%.4g mm deeper than any other contact", margin / kMillimetre)
                                                  : std::string("the only contact");
    return "pushes, with " + std::string(featureWord(contact.feature)) + ": " + why;
  }
  if (candidate.rank > 0) return "pushes too: it still holds the ellipsoid after the push of the deeper ones";
  if (centre_height <= 0.0)
    return words("no contact: the ellipsoid's centre is %.4g mm behind it, and it is one-sided",
                 -centre_height / kMillimetre);
  if (candidate.plane_depth <= 0.0)
    return words("no contact: its plane is %.4g mm below the ellipsoid", -candidate.plane_depth / kMillimetre);
  if (!contact) return "no contact: its plane is reached, but beyond its edges";
  if (!candidate.admitted)
    return words(
        "turned away by the contact memory: %.4g mm deep, but it came into front from behind or was hidden by "
        "other contacts",
        contact.depth / kMillimetre);
  if (winner == nullptr) return words("%.4g mm deep", contact.depth / kMillimetre);
  if (isSame(contact, winner->alone))
    return "the same contact as triangle " + std::to_string(winner->triangle) +
           " makes, at the edge or corner they share";
  return words("%.4g mm deep, %.4g mm less than ", contact.depth / kMillimetre,
               (winner->alone.depth - contact.depth) / kMillimetre) +
         "triangle " + std::to_string(winner->triangle) + ", whose push clears it";
}

}  // namespace

ContactExplanation explain(const ContactMemory& now, const ContactMemory& before, const Terrain& terrain,
                           const ContactOptions& options, int ellipsoid, const std::vector<ContactReport>& reports) {
  ContactExplanation result;
  result.slack = now.slack;
  result.margin = std::numeric_limits<double>::infinity();
  if (now.fresh) return result;
  for (const ContactReport& report : reports)
    if (report.ellipsoid == ellipsoid && report.triangle >= 0) result.contacts.push_back(report);

  const PosedEllipsoid& posed = now.posed;
  const Eigen::Vector3d half = posed.halfBox();
  std::vector<int> triangles;
  terrain.query(Eigen::AlignedBox3d(Eigen::Vector3d(posed.p_WE - half), Eigen::Vector3d(posed.p_WE + half)), triangles);
  std::sort(triangles.begin(), triangles.end());
  std::vector<double> heights;
  for (const int index : triangles) {
    const Triangle triangle = terrain.triangle(index);
    CandidateReport candidate;
    candidate.triangle = index;
    heights.push_back(triangle.nhat_W.dot(posed.p_WE - triangle.v[0]));
    candidate.plane_depth = posed.halfWidth(triangle.nhat_W) - heights.back();
    candidate.alone = options.rule == ContactRule::kMinimumTranslation ? minimumTranslation(posed, triangle)
                                                                       : clampedPoint(posed, triangle);
    ContactFinder finder;
    candidate.admitted =
        candidate.alone &&
        findContacts(posed, renumbered(before, index), onlyTriangle(triangle), options, finder).count > 0;
    for (std::size_t i = 0; i < result.contacts.size(); ++i)
      if (result.contacts[i].triangle == index) candidate.rank = static_cast<int>(i);
    result.candidates.push_back(candidate);
  }

  const auto winner = std::find_if(result.candidates.begin(), result.candidates.end(),
                                   [](const CandidateReport& candidate) { return candidate.rank == 0; });
  const CandidateReport* first = winner == result.candidates.end() ? nullptr : &*winner;
  if (first != nullptr)
    for (const CandidateReport& other : result.candidates)
      if (other.admitted && other.rank != 0 && !isSame(other.alone, first->alone))
        result.margin = std::min(result.margin, first->alone.depth - other.alone.depth);
  for (std::size_t i = 0; i < result.candidates.size(); ++i)
    result.candidates[i].reason = reasonOf(result.candidates[i], heights[i], first, result.margin);
  return result;
}

}  // namespace ellipsoid_vehicle_sim
