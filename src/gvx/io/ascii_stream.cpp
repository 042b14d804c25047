#include "gvx/io/ascii_stream.h"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <system_error>
#include <type_traits>

#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

constexpr std::size_t kLongestToken = 128;

bool separates(std::byte b) {
  const char c = static_cast<char>(b);
  return c == ' ' || c == ',' || (c >= '\t' && c <= '\r');
}

/// Integers that a double does not hold to the last digit.
template <typename T>
inline constexpr bool kIsLong = std::is_integral_v<T> && sizeof(T) > sizeof(std::int32_t);

template <typename T>
bool store_sample(const std::string& token, std::byte* out) {
  if constexpr (kIsLong<T>) {
    T sample{};
    const char* const end = token.data() + token.size();
    if (const auto read = std::from_chars(token.data(), end, sample);
        read.ec == std::errc{} && read.ptr == end) {
      std::memcpy(out, &sample, sizeof sample);
      return true;
    }
  }
  const std::optional<double> number = parse_number(token);
  if (!number) return false;
  const double value = *number;
  if constexpr (std::is_integral_v<T>) {
    // The greatest of 64 bits is no double, and the next one is too large.
    const auto most = static_cast<double>(std::numeric_limits<T>::max());
    const bool fits = value >= static_cast<double>(std::numeric_limits<T>::min()) &&
                      (kIsLong<T> ? value < most : value <= most);
    if (!fits || value != std::floor(value)) return false;
  } else if (std::isfinite(value) && std::abs(value) > double{std::numeric_limits<T>::max()}) {
    return false;
  }
  const T sample = static_cast<T>(value);
  std::memcpy(out, &sample, sizeof sample);
  return true;
}

class AsciiStream final : public ByteStream {
 public:
  AsciiStream(FileSource source, SampleType type) : ByteStream(std::move(source)), type_(type) {}

  Result<std::size_t> read(std::span<std::byte> out) override {
    const std::size_t step = sample_bytes(type_);
    GVX_CHECK(out.size() % step == 0);
    for (std::size_t done = 0; done < out.size(); done += step) {
      GVX_ASSIGN(const bool found, next_token());
      if (!found) return done;
      const bool stored = with_sample_type(
          type_, [&](auto sample) { return store_sample<decltype(sample)>(token_, out.data() + done); });
      if (!stored) {
        return file_error(name(), std::string("expected a number of type ") + sample_name(type_) +
                                      ", found " + quoted(token_));
      }
    }
    return out.size();
  }

 private:
  Status restart() override { return {}; }

  Result<bool> next_token() {
    token_.clear();
    for (;;) {
      GVX_ASSIGN(const auto bytes, source_.peek());
      std::size_t used = 0;
      while (used < bytes.size() && token_.empty() && separates(bytes[used])) ++used;
      while (used < bytes.size() && !separates(bytes[used])) {
        if (token_.size() == kLongestToken) {
          return file_error(name(), "expected a number, found " + quoted(token_));
        }
        token_ += static_cast<char>(bytes[used++]);
      }
      const bool complete = bytes.empty() || used < bytes.size();
      source_.consume(used);
      if (complete) return !token_.empty();
    }
  }

  SampleType type_;
  std::string token_;
};

}  // namespace

std::unique_ptr<ByteStream> make_ascii_stream(FileSource source, SampleType type) {
  return std::make_unique<AsciiStream>(std::move(source), type);
}

}  // namespace gvx::io
