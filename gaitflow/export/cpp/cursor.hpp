// Takes items off map.bin in order: sizes are checked before memory is taken, whatever is wrong is a MapError.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

namespace gaitflow {

struct MapError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

namespace detail {

constexpr std::size_t start_size = 56, most_bytes = std::size_t{1} << 30;
constexpr double largest = 1e15;  // of a stored number: far above what maps hold

// Takes items off the file in order; each begins at a multiple of 8 bytes.
class Cursor {
 public:
  Cursor(const std::string& path, const std::vector<unsigned char>& bytes) : path_(path), bytes_(bytes) {}

  [[noreturn]] void refuse(const std::string& fault) const {
    throw MapError(path_ + ": " + fault + "; export the map again");
  }

  void require(bool holds, const char* fault) const {
    if (!holds) refuse(fault);
  }

  template <class Number>
  std::vector<Number> array(std::size_t count) {
    if (count > (bytes_.size() - at_) / sizeof(Number)) refuse("an array is longer than the file");
    std::vector<Number> values(count);
    const std::size_t size = count * sizeof(Number);
    if (size != 0) std::memcpy(values.data(), bytes_.data() + at_, size);
    const std::size_t padded = size + (8 - size % 8) % 8;
    if (padded > bytes_.size() - at_) refuse("an array is longer than the file");
    at_ += padded;
    return values;
  }

  // Numbers of which products of several are still finite.
  template <class Number>
  std::vector<Number> finite(std::size_t count) {
    std::vector<Number> values = array<Number>(count);
    for (const Number value : values) require(std::abs(value) <= largest, "a number is not finite, or beyond 1e15");
    return values;
  }

  // Bounds that may be infinite on their own side: below when `side` is -1, above when it is 1.
  std::vector<double> bounds(std::size_t count, double side) {
    std::vector<double> values = array<double>(count);
    for (const double value : values)
      require(std::abs(value) <= largest || (std::isinf(value) && side * value > 0), "a bound is no number that one has");
    return values;
  }

  // A number of things of which the file has room for one byte each, at least.
  std::size_t count(std::size_t least, std::size_t most, const char* fault) {
    const std::uint64_t value = array<std::uint64_t>(1)[0];
    require(least <= value && value <= most, fault);
    return static_cast<std::size_t>(value);
  }

  // Unsigned integers of 4 bytes, each below `end`.
  std::vector<std::uint32_t> places(std::size_t count, std::size_t end, const char* fault) {
    std::vector<std::uint32_t> values = array<std::uint32_t>(count);
    for (const std::uint32_t value : values) require(value < end, fault);
    return values;
  }

  std::string text() {
    const std::vector<char> letters = array<char>(count(0, 100000, "a text is too long"));
    return std::string(letters.begin(), letters.end());
  }

  std::vector<double> axis(std::size_t size) {
    std::vector<double> values = finite<double>(size);
    for (std::size_t i = 1; i < size; ++i) require(values[i - 1] < values[i], "an axis does not rise");
    return values;
  }

  bool ended() const { return at_ == bytes_.size(); }

 private:
  const std::string& path_;
  const std::vector<unsigned char>& bytes_;
  std::size_t at_ = start_size;
};

}  // namespace detail

}  // namespace gaitflow
