#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "mesh_readers.h"
#include "xml_tree.h"

namespace ellipsoid_vehicle_sim {

/// The polygons of a DAE's <geometry>: corners of polygon i are corners[ends[i - 1]] ... corners[ends[i] - 1].
struct DaeShape {
  std::vector<Eigen::Vector3d> vertices;  ///< those that are used, in order of first use.
  std::vector<std::uint32_t> corners;
  std::vector<std::size_t> ends;
  std::size_t lines = 0;  ///< and points, left out.
};

/// Reads the geometries of a DAE as they are asked for, each once.
class DaeShapes {
 public:
  DaeShapes(const XmlTree& tree, const std::string& path, Problems& problems);

  /// The shape of <geometry id="...">, or of the one that <controller id="..."> is the skin of; nullptr: there is none.
  const DaeShape* shape(const std::string& id);

 private:
  using Element = XmlTree::Element;

  const Element* find(const std::string& id) const;
  const Element* follow(const Element& from, const char* attribute, const char* name);
  const Element* input(const Element& of, const char* semantic) const;
  std::optional<double> count(const Element& element, const char* attribute, double without);
  std::optional<std::vector<double>> numbers(const Element& array);
  /// The points of a <source>, and their numbers in the shape that is being read.
  struct Points {
    std::vector<Eigen::Vector3d> points;
    std::vector<std::uint32_t> number, number_of;  ///< `number` holds for the shape `number_of`.
  };
  Points& positions(const Element& source);
  std::vector<std::uint32_t> indices(const Element& element, bool& readable);
  void readPrimitive(const Element& primitive, DaeShape& shape);
  void problem(const Element& element, const std::string& message);

  const XmlTree& tree_;
  const std::string& path_;
  Problems& problems_;
  NumberReader number_reader_;
  std::map<std::string, int> by_id_;
  std::map<std::string, DaeShape> shapes_;
  std::map<const Element*, Points> positions_;
  std::uint32_t shape_count_ = 0;
};

}  // namespace ellipsoid_vehicle_sim
