#include "gvx/mesh/mesh_inside.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_map>
#include <utility>

namespace gvx::mesh {
namespace {

using Key = std::array<double, 3>;

/// The two zeros are one place.
Key key_of(Vec3d v) {
  return {v.x + 0.0, v.y + 0.0, v.z + 0.0};
}

/// Bits that depend on all of h (Appleby's MurmurHash3, its finalizer).
std::uint64_t mixed(std::uint64_t h) {
  h = (h ^ (h >> 33)) * 0xff51afd7ed558ccdull;
  h = (h ^ (h >> 33)) * 0xc4ceb9fe1a85ec53ull;
  return h ^ (h >> 33);
}

std::uint64_t hash(std::uint64_t seed, const Key& key) {
  for (const double v : key) seed = mixed(seed + 0x9e3779b97f4a7c15ull + std::bit_cast<std::uint64_t>(v));
  return seed;
}

std::array<std::uint64_t, 2> hash_of_edge(const Key& a, const Key& b) {
  const Key &low = std::min(a, b), &high = std::max(a, b);
  return {hash(hash(0, low), high), hash(hash(1, low), high)};
}

/// Of places that are near to each other, one for all.
class Welder {
 public:
  Welder(std::vector<Key> places, double tolerance) : places_(std::move(places)), tolerance_(tolerance) {
    std::sort(places_.begin(), places_.end());
    places_.erase(std::unique(places_.begin(), places_.end()), places_.end());
    for (std::size_t i = 0; i < places_.size(); ++i) {
      parents_.push_back(i);
      join_neighbors(i);
      cells_.emplace(cell(places_[i], {}), i);
    }
  }

  Vec3d one_for(const Key& place) {
    const auto found = std::lower_bound(places_.begin(), places_.end(), place);
    const Key& one = places_[root(static_cast<std::size_t>(found - places_.begin()))];
    return {one[0], one[1], one[2]};
  }

 private:
  std::uint64_t cell(const Key& place, std::array<int, 3> step) const {
    Key at;
    for (std::size_t axis = 0; axis < 3; ++axis) at[axis] = std::floor(place[axis] / tolerance_) + step[axis];
    return hash(0, at);
  }

  void join_neighbors(std::size_t i) {
    for (int n = 0; n < 27; ++n) {
      const auto [first, last] = cells_.equal_range(cell(places_[i], {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1}));
      for (auto other = first; other != last; ++other) {
        double apart = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          apart = std::max(apart, std::fabs(places_[i][axis] - places_[other->second][axis]));
        }
        if (apart <= tolerance_) parents_[root(i)] = root(other->second);
      }
    }
  }

  std::size_t root(std::size_t i) {
    while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
    return i;
  }

  std::vector<Key> places_;
  double tolerance_;
  std::vector<std::size_t> parents_;
  std::unordered_multimap<std::uint64_t, std::size_t> cells_;
};

}  // namespace

void EdgeSums::add(const Corners& corners) {
  for (std::size_t k = 0; k < 3; ++k) add_edge(corners[k], corners[(k + 1) % 3]);
}

void EdgeSums::add_edge(Vec3d a, Vec3d b) {
  const Key from = key_of(a), to = key_of(b);
  if (from == to) return;
  const std::array<std::uint64_t, 2> edge = hash_of_edge(from, to);
  for (std::size_t i = 0; i < odd_.size(); ++i) {
    odd_[i] ^= edge[i];
    ways_[i] += from < to ? edge[i] : 0 - edge[i];
  }
}

std::optional<EdgeRecord> EdgeRecord::of(Vec3d a, Vec3d b, std::uint64_t edge) {
  const Key from = key_of(a), to = key_of(b);
  if (from == to) return {};
  return EdgeRecord{hash_of_edge(from, to), 2 * edge + (from < to ? 1 : 0)};
}

void OpenEdges::take(const EdgeRecord& record) {
  if (record.key != key_) end_edge();
  key_ = record.key;
  same_.push_back(record.index);
}

void OpenEdges::end_edge() {
  const auto forth = std::count_if(same_.begin(), same_.end(), [](std::uint64_t i) { return i % 2 != 0; });
  const bool open = 2 * static_cast<std::size_t>(forth) != same_.size();
  too_many_ = too_many_ || (open && open_.size() + same_.size() > kMost);
  if (open && !too_many_) open_.insert(open_.end(), same_.begin(), same_.end());
  same_.clear();
}

std::vector<std::uint64_t> OpenEdges::finish() {
  end_edge();
  if (too_many_) return {};
  for (std::uint64_t& index : open_) index /= 2;
  std::sort(open_.begin(), open_.end());
  return std::move(open_);
}

FaceRecord FaceRecord::of(const EdgeSums::Corners& corners, std::uint64_t index) {
  std::array<Key, 3> keys;
  std::transform(corners.begin(), corners.end(), keys.begin(), key_of);
  bool flipped = false;
  for (const auto& [i, j] : {std::pair{0u, 1u}, {1u, 2u}, {0u, 1u}}) {
    if (keys[j] < keys[i]) {
      std::swap(keys[i], keys[j]);
      flipped = !flipped;
    }
  }
  const auto of_all = [&](std::uint64_t seed) { return hash(hash(hash(seed, keys[0]), keys[1]), keys[2]); };
  return {{of_all(2), of_all(3)}, index, flipped};
}

void InsideJudge::add(const EdgeSums::Corners& corners) {
  all_.add(corners);
  const FaceRecord face = FaceRecord::of(corners, 0);
  for (std::size_t i = 0; i < faces_.size(); ++i) faces_[i] += face.flipped ? 0 - face.key[i] : face.key[i];
}

void InsideJudge::weld(std::span<const std::array<Vec3d, 2>> open, double tolerance) {
  if (open.empty() || !(tolerance > 0)) return;
  std::vector<Key> places;
  for (const auto& [a, b] : open) places.insert(places.end(), {key_of(a), key_of(b)});
  Welder welder(std::move(places), tolerance);
  EdgeSums sums;
  for (const auto& [a, b] : open) sums.add_edge(welder.one_for(key_of(a)), welder.one_for(key_of(b)));
  if (sums.balanced()) {
    welded_ = InsideRule::winding;
  } else if (sums.even()) {
    welded_ = InsideRule::parity;
  }
}

void InsideJudge::take(const FaceRecord& record, std::uint64_t count) {
  copies_.resize(static_cast<std::size_t>(count));
  back_.resize(static_cast<std::size_t>(count));
  if (record.key != key_ || fronts_ == 0) {
    key_ = record.key;
    met_ = {};
  }
  const std::size_t way = record.flipped ? 1 : 0;
  if (met_[way]) {
    copies_[static_cast<std::size_t>(record.index)] = true;
  } else if (met_[1 - way]) {
    back_[static_cast<std::size_t>(record.index)] = true;
    ++backs_;
  } else {
    ++fronts_;
  }
  met_[way] = true;
}

void InsideJudge::weigh(const EdgeSums::Corners& corners, std::uint64_t index) {
  const auto i = static_cast<std::size_t>(index);
  if (copies_[i]) return;
  without_copies_.add(corners);
  if (!back_[i]) once_.add(corners);
}

bool InsideJudge::drops_copies() const {
  return !settled() && without_copies_.balanced() && !has_backs_only();
}

InsideRule InsideJudge::rule() const {
  if (settled()) return welded_.value_or(InsideRule::winding);
  if (fronts_ == 0) return InsideRule::none;
  if (drops_copies()) return InsideRule::winding;
  // Parts that touch share faces, which count as often as they are there.
  return once_.even() || (all_.even() && !has_backs_only()) ? InsideRule::parity : InsideRule::none;
}

bool InsideJudge::is_spare(std::uint64_t index) const {
  const auto i = static_cast<std::size_t>(index);
  if (settled() || i >= copies_.size()) return false;
  return drops_copies() ? copies_[i] : drops_backs() && (copies_[i] || back_[i]);
}

double weld_distance(const Box3d& bounds) {
  double farthest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    farthest = std::max({farthest, std::fabs(bounds.minimum[axis]), std::fabs(bounds.maximum[axis])});
  }
  return 0x1p-22 * max_component(bounds.maximum - bounds.minimum) + 0x1p-50 * farthest;
}

InsideRule settle_inside(io::TriangleMesh& mesh) {
  InsideJudge judge;
  const std::size_t count = mesh.triangles.size();
  const auto corners = [&](std::size_t i) {
    const io::Triangle& t = mesh.triangles[i];
    return EdgeSums::Corners{Vec3d(mesh.vertices[t[0]]), Vec3d(mesh.vertices[t[1]]),
                             Vec3d(mesh.vertices[t[2]])};
  };
  for (std::size_t i = 0; i < count; ++i) judge.add(corners(i));
  if (!judge.settled() && judge.may_weld()) {
    std::vector<EdgeRecord> records;
    const auto collect = [&](const EdgeRecord& record) {
      records.push_back(record);
      return Status();
    };
    for (std::size_t i = 0; i < count; ++i) GVX_CHECK(for_each_edge(corners(i), i, collect).ok());
    std::sort(records.begin(), records.end());
    OpenEdges edges;
    for (const EdgeRecord& record : records) edges.take(record);
    std::vector<std::array<Vec3d, 2>> open;
    for (const std::uint64_t edge : edges.finish()) {
      const EdgeSums::Corners of = corners(static_cast<std::size_t>(edge / 3));
      open.push_back({of[edge % 3], of[(edge + 1) % 3]});
    }
    Box3d bounds = mesh.bounds();
    bounds = {bounds.minimum - mesh.origin, bounds.maximum - mesh.origin};
    judge.weld(open, weld_distance(bounds));
  }
  if (!judge.settled()) {
    std::vector<FaceRecord> records;
    for (std::size_t i = 0; i < count; ++i) records.push_back(FaceRecord::of(corners(i), i));
    std::sort(records.begin(), records.end());
    for (const FaceRecord& record : records) judge.take(record, count);
    for (std::size_t i = 0; i < count; ++i) judge.weigh(corners(i), i);
    std::vector<io::Triangle> kept;
    for (std::size_t i = 0; i < count; ++i) {
      if (!judge.is_spare(i)) kept.push_back(mesh.triangles[i]);
    }
    mesh.triangles = std::move(kept);
  }
  return judge.rule();
}

}  // namespace gvx::mesh
