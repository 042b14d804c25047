// Writes a torus with bumps and colours as binary PLY to standard output: a closed surface of about COUNT
// triangles, made of rings, for which no file of that size is needed.
//
//     gvx_make_torus COUNT > torus.ply

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

namespace {

/// Bytes that go out in great pieces.
class Output {
 public:
  ~Output() { flush(); }

  template <typename Value>
  void put(Value value) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof(value));
    std::memcpy(&bytes_[at], &value, sizeof(value));
    if (bytes_.size() > (1 << 20)) flush();
  }

  bool good() const { return good_; }

  void flush() {
    good_ = std::fwrite(bytes_.data(), 1, bytes_.size(), stdout) == bytes_.size() && good_;
    bytes_.clear();
  }

 private:
  std::vector<char> bytes_;
  bool good_ = true;
};

}  // namespace

int main(int argc, char** argv) {
  const double count = argc == 2 ? std::atof(argv[1]) : 0;
  // Rings go three times as far as around the tube.
  const auto around = static_cast<std::uint32_t>(std::sqrt(count / 6));
  if (around < 3 || count > 4e9) {
    std::fprintf(stderr, "usage: gvx_make_torus COUNT > FILE, of 54 to 4e9 triangles\n");
    return 2;
  }
  const std::uint32_t rings = 3 * around;
  std::printf(
      "ply\nformat binary_little_endian 1.0\nelement vertex %llu\nproperty float x\nproperty float y\n"
      "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face %llu\n"
      "property list uchar uint vertex_indices\nend_header\n",
      static_cast<unsigned long long>(rings) * around, 2ull * rings * around);
  Output out;
  for (std::uint32_t i = 0; i < rings; ++i) {
    const double u = 2 * M_PI * i / rings;
    for (std::uint32_t j = 0; j < around; ++j) {
      const double v = 2 * M_PI * j / around;
      const double bump =
          std::sin(11 * u) * std::sin(5 * v) + 0.3 * std::sin(53 * u + 2 * v) * std::sin(31 * v);
      const double tube = 0.35 + 0.05 * bump, far = 1 + tube * std::cos(v);
      out.put(static_cast<float>(far * std::cos(u)));
      out.put(static_cast<float>(far * std::sin(u)));
      out.put(static_cast<float>(tube * std::sin(v)));
      for (const double phase : {0.0, 2.1, 4.2}) {
        out.put(static_cast<std::uint8_t>(160 + 60 * std::sin(2 * u + v + phase) + 20 * bump));
      }
    }
  }
  for (std::uint32_t i = 0; i < rings; ++i) {
    for (std::uint32_t j = 0; j < around; ++j) {
      const std::uint32_t k = (i + 1) % rings, l = (j + 1) % around;
      const auto vertex = [&](std::uint32_t ring, std::uint32_t place) { return ring * around + place; };
      for (const std::uint32_t last : {0, 1}) {
        out.put(std::uint8_t{3});
        out.put(vertex(i, j));
        out.put(last ? vertex(k, l) : vertex(k, j));
        out.put(last ? vertex(i, l) : vertex(k, l));
      }
    }
  }
  out.flush();
  return out.good() && std::fflush(stdout) == 0 ? 0 : 1;
}
