#include "gvx/io/ascii_stream.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

constexpr std::size_t kLongestToken = 128;

bool separates(std::byte b) {
  const char c = static_cast<char>(b);
  return c == ' ' || c == ',' || (c >= '\t' && c <= '\r');
}

template <typename T>
bool store_sample(double value, std::byte* out) {
  if constexpr (std::is_integral_v<T>) {
    const bool fits =
        value >= double{std::numeric_limits<T>::min()} && value <= double{std::numeric_limits<T>::max()};
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
      const std::optional<double> value = parse_number(token_);
      const bool stored = value && with_sample_type(type_, [&](auto sample) {
                            return store_sample<decltype(sample)>(*value, out.data() + done);
                          });
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
