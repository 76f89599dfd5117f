// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "osteomill/base/error.hpp"

/// The state of a computation as bytes, to go on from later on the same machine with the same
/// program: numbers as they lie in memory, vectors with their length.
///
/// A class that can be kept names its members once:
///   template <class Archive> void exchange(Archive& a) { a(count_, cells_, child_); }
/// and takes them back into an object that was made in the same way.
namespace osteomill {

namespace archive {

/// Kept as it lies in memory.
template <class T>
inline constexpr bool is_plain = std::is_trivially_copyable_v<T>;
/// Of a fixed number of plain values in a row, though not trivially copyable: Eigen's vectors.
template <class T>
concept FixedRow = requires(T& value) {
  value.data();
  T::SizeAtCompileTime;
} && T::SizeAtCompileTime > 0;

}  // namespace archive

class Saver {
 public:
  template <class... T>
  void operator()(T&... values) {
    (put(values), ...);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  void raw(const void* from, std::size_t size) {
    bytes_.append(static_cast<const char*>(from), size);
  }
  template <class T>
  void put(T& value) {
    if constexpr (archive::FixedRow<T>) {
      raw(value.data(), sizeof(*value.data()) * static_cast<std::size_t>(T::SizeAtCompileTime));
    } else if constexpr (requires { value.exchange(*this); }) {
      value.exchange(*this);
    } else {
      static_assert(archive::is_plain<T>, "give it an exchange()");
      raw(&value, sizeof value);
    }
  }
  template <class T, class Allocator>
  void put(std::vector<T, Allocator>& values) {
    const std::uint64_t count = values.size();
    raw(&count, sizeof count);
    if constexpr (archive::is_plain<T>) {
      raw(values.data(), values.size() * sizeof(T));
    } else {
      for (T& value : values) put(value);
    }
  }
  std::string bytes_;
};

class Loader {
 public:
  explicit Loader(std::string_view bytes) : left_(bytes) {}
  template <class... T>
  void operator()(T&... values) {
    (take(values), ...);
  }
  bool at_end() const { return left_.empty(); }

 private:
  /// Throws InvalidInput when the bytes end early.
  void raw(void* to, std::size_t size) {
    if (size > left_.size())
      throw InvalidInput(Fault{"checkpoint", "ends early", "must be whole", "start without it"});
    std::memcpy(to, left_.data(), size);
    left_.remove_prefix(size);
  }
  template <class T>
  void take(T& value) {
    if constexpr (archive::FixedRow<T>) {
      raw(value.data(), sizeof(*value.data()) * static_cast<std::size_t>(T::SizeAtCompileTime));
    } else if constexpr (requires { value.exchange(*this); }) {
      value.exchange(*this);
    } else {
      static_assert(archive::is_plain<T>, "give it an exchange()");
      raw(&value, sizeof value);
    }
  }
  template <class T, class Allocator>
  void take(std::vector<T, Allocator>& values) {
    std::uint64_t count = 0;
    raw(&count, sizeof count);
    if (count > left_.size())
      throw InvalidInput(Fault{"checkpoint", "ends early", "must be whole", "start without it"});
    values.resize(count);
    if constexpr (archive::is_plain<T>) {
      raw(values.data(), values.size() * sizeof(T));
    } else {
      for (T& value : values) take(value);
    }
  }
  std::string_view left_;
};

}  // namespace osteomill
