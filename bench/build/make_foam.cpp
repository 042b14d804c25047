// Writes a foam of SIZE^3 u8 voxels to standard output, slice by slice: walls between cells around jittered
// points, whose brightness varies from cell to cell. The same bytes for the same size, everywhere; no file of
// that size is needed.
//
//     gvx_make_foam SIZE [CELL] | gvx build - -o foam.gvx --dims SIZE,SIZE,SIZE --dtype u8
//
// A cell is CELL voxels wide (32): twice the size and the cell, and it is the same foam in finer voxels.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <tbb/parallel_for.h>

namespace {

std::uint32_t hash(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  std::uint32_t h = x * 0x8da6b343u ^ y * 0xd8163841u ^ z * 0xcb1ab31fu;
  h = (h ^ h >> 15) * 0x2c1b3c6du;
  h = (h ^ h >> 12) * 0x297a2d39u;
  return h ^ h >> 15;
}

struct Point {
  float x, y, z;
};

/// The 27 points around a grid cell.
void points_around(int cell, int cx, int cy, int cz, Point* points) {
  for (int k = -1; k <= 1; ++k) {
    for (int j = -1; j <= 1; ++j) {
      for (int i = -1; i <= 1; ++i) {
        const std::uint32_t h = hash(static_cast<std::uint32_t>(cx + i), static_cast<std::uint32_t>(cy + j),
                                     static_cast<std::uint32_t>(cz + k));
        const auto jitter = [h](int shift) { return float(h >> shift & 1023) / 1023.0f; };
        const auto width = static_cast<float>(cell);
        *points++ = {(float(cx + i) + jitter(0)) * width, (float(cy + j) + jitter(10)) * width,
                     (float(cz + k) + jitter(20)) * width};
      }
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  const int size = argc == 2 || argc == 3 ? std::atoi(argv[1]) : 0;
  const int cell_width = argc == 3 ? std::atoi(argv[2]) : 32;  // of the grid that the points jitter in
  if (size < 1 || size > 16384 || cell_width < 1 || cell_width > size) {
    std::fprintf(stderr, "usage: gvx_make_foam SIZE [CELL] > FILE\n");
    return 2;
  }
  std::vector<std::uint8_t> slice(static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
  const float steepness = 60.0f * 32.0f / static_cast<float>(cell_width);  // of the walls
  const int cells = (size + cell_width - 1) / cell_width;
  for (int z = 0; z < size; ++z) {
    tbb::parallel_for(0, cells * cells, [&](int cell) {
      const int cx = cell % cells, cy = cell / cells;
      Point points[27];
      points_around(cell_width, cx, cy, z / cell_width, points);
      for (int y = cy * cell_width; y < std::min(size, (cy + 1) * cell_width); ++y) {
        for (int x = cx * cell_width; x < std::min(size, (cx + 1) * cell_width); ++x) {
          float nearest = 1e9f, second = 1e9f;
          for (const Point& p : points) {
            const float dx = p.x - float(x), dy = p.y - float(y), dz = p.z - float(z);
            const float d = dx * dx + dy * dy + dz * dz;
            second = d < nearest ? nearest : std::min(second, d);
            nearest = std::min(nearest, d);
          }
          const float wall = std::sqrt(second) - std::sqrt(nearest);
          slice[static_cast<std::size_t>(y) * static_cast<std::size_t>(size) + static_cast<std::size_t>(x)] =
              static_cast<std::uint8_t>(std::max(0.0f, 250.0f - steepness * wall));
        }
      }
    });
    if (std::fwrite(slice.data(), 1, slice.size(), stdout) != slice.size()) return 1;
  }
  return std::fflush(stdout) == 0 ? 0 : 1;
}
