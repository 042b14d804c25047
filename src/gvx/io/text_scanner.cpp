#include "gvx/io/text_scanner.h"

#include <algorithm>
#include <cstring>

#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

bool is_blank(std::byte byte) {
  const auto c = static_cast<char>(byte);
  return c == ' ' || c == '\n' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

}  // namespace

TextScanner::TextScanner(std::unique_ptr<ByteStream> stream) : stream_(std::move(stream)) {}

Error TextScanner::error(const std::string& message) const {
  return file_error(stream_->name(), message);
}

Result<bool> TextScanner::fill() {
  if (begin_ < end_) return true;
  buffer_.resize(1 << 16);
  begin_ = end_ = 0;
  GVX_ASSIGN(end_, stream_->read(buffer_));
  return end_ > 0;
}

Result<std::optional<char>> TextScanner::peek() {
  GVX_ASSIGN(const bool more, fill());
  return more ? std::optional(static_cast<char>(buffer_[begin_])) : std::nullopt;
}

Status TextScanner::read(std::span<std::byte> out) {
  while (!out.empty()) {
    GVX_ASSIGN(const bool more, fill());
    if (!more) return error("ends early");
    const std::size_t count = std::min(out.size(), end_ - begin_);
    std::memcpy(out.data(), buffer_.data() + begin_, count);
    begin_ += count;
    out = out.subspan(count);
  }
  return {};
}

Result<bool> TextScanner::line(std::string& text, std::size_t most) {
  GVX_ASSIGN(const std::optional<char> end, line_until("\n\r", text, most));
  if (end == '\r') {
    GVX_ASSIGN(const std::optional<char> next, peek());
    if (next == '\n') ++begin_;
  }
  return end.has_value() || !text.empty();
}

Result<std::optional<char>> TextScanner::line_until(std::string_view ends, std::string& text,
                                                    std::size_t most) {
  text.clear();
  while (true) {
    GVX_ASSIGN(const bool more, fill());
    if (!more) return std::optional<char>();
    const std::string_view waiting(reinterpret_cast<const char*>(buffer_.data()) + begin_, end_ - begin_);
    const std::size_t count = std::min(waiting.find_first_of(ends), waiting.size());
    if (text.size() + count > most) {
      return error("a line does not end within " + std::to_string(most) + " bytes");
    }
    text.append(waiting.substr(0, count));
    begin_ += count;
    if (count < waiting.size()) return std::optional(static_cast<char>(buffer_[begin_++]));
  }
}

Result<std::string_view> TextScanner::word(std::size_t most) {
  word_.clear();
  while (true) {
    GVX_ASSIGN(const bool more, fill());
    if (!more) return std::string_view(word_);
    while (begin_ < end_) {
      const std::byte byte = buffer_[begin_++];
      if (is_blank(byte)) {
        if (!word_.empty()) return std::string_view(word_);
        continue;
      }
      if (word_.size() == most)
        return error(io::quoted(word_) + " begins a word of more than " + std::to_string(most) + " bytes");
      word_.push_back(static_cast<char>(byte));
    }
  }
}

Result<double> TextScanner::number() {
  GVX_ASSIGN(const std::string_view text, word(64));
  if (text.empty()) return error("ends early");
  const auto value = parse_number(text);
  if (!value) return error(io::quoted(text) + " is not a number");
  return *value;
}

std::optional<std::uint64_t> TextScanner::bytes_left() const {
  const auto left = stream_->bytes_left();
  return left ? std::optional(*left + (end_ - begin_)) : std::nullopt;
}

}  // namespace gvx::io
