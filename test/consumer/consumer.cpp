#include <cstdio>

#include "ellipsoid_vehicle_sim/world/terrain.h"

int main() {
  ellipsoid_vehicle_sim::TriangleSoup soup;
  soup.vertices = {{0, 0, 2}, {3, 0, 2}, {0, 3, 2}};
  soup.triangles = {{0, 1, 2}};
  soup.surface = {0};
  soup.surfaces = {{"ground", {}, {}}};
  const auto terrain = ellipsoid_vehicle_sim::Terrain::build(soup);
  std::printf("height %g\n", terrain.value->heights(1.0, 1.0).front().z);
}
