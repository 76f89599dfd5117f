// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <type_traits>
#include <utility>
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

class Archive {
 public:
  /// Takes the bytes that lie there somewhere, or fills them from there.
  using Pass = std::function<void(void* at, std::size_t size)>;

  static Archive saving(Pass pass) { return Archive(std::move(pass), false, 0); }
  /// `most`: bytes that there are; no vector can have more values.
  static Archive loading(Pass pass, std::uint64_t most) {
    return Archive(std::move(pass), true, most);
  }

  /// Passes every number of the values on. InvalidInput when a vector is longer than can be.
  template <class... T>
  void operator()(T&... values) {
    (one(values), ...);
  }

 private:
  Archive(Pass pass, bool loads, std::uint64_t most)
      : pass_(std::move(pass)), loads_(loads), most_(most) {}

  template <class T>
  void one(T& value) {
    if constexpr (archive::FixedRow<T>) {
      pass_(value.data(), sizeof(*value.data()) * static_cast<std::size_t>(T::SizeAtCompileTime));
    } else if constexpr (requires { value.exchange(*this); }) {
      value.exchange(*this);
    } else {
      static_assert(archive::is_plain<T>, "give it an exchange()");
      pass_(&value, sizeof value);
    }
  }
  template <class T, class Allocator>
  void one(std::vector<T, Allocator>& values) {
    std::uint64_t count = values.size();
    pass_(&count, sizeof count);
    if (loads_ && count > most_)
      throw InvalidInput(
          Fault{"checkpoint", "of another form", "must be whole", "start without it"});
    if (loads_) values.resize(count);
    if constexpr (archive::is_plain<T>) {
      pass_(values.data(), values.size() * sizeof(T));
    } else {
      for (T& value : values) one(value);
    }
  }

  Pass pass_;
  bool loads_;
  std::uint64_t most_;
};

}  // namespace osteomill
