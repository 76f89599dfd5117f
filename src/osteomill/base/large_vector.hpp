// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <new>
#include <vector>

namespace osteomill {

/// Memory for arrays that are visited row by row in many places: from a few megabytes on it asks
/// for huge pages, so that each row does not cost a search for its page. Values are as they would
/// be without.
template <class T>
struct LargeAllocator {
  using value_type = T;
  LargeAllocator() = default;
  template <class U>
  LargeAllocator(const LargeAllocator<U>&) {}

  T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    const auto alignment = std::align_val_t{bytes >= kFrom ? kPage : alignof(std::max_align_t)};
    void* memory = ::operator new(bytes, alignment);
    if (bytes >= kFrom) madvise(memory, bytes, MADV_HUGEPAGE);  // a wish: nothing fails without
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    ::operator delete(memory, std::align_val_t{bytes >= kFrom ? kPage : alignof(std::max_align_t)});
  }
  bool operator==(const LargeAllocator&) const { return true; }

 private:
  static constexpr std::size_t kPage = 2u << 20;
  static constexpr std::size_t kFrom = 4u << 20;
};

template <class T>
using LargeVector = std::vector<T, LargeAllocator<T>>;

}  // namespace osteomill
