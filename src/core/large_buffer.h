// Arrays of many megabytes that are read here and there: aligned, and on large pages where the system has them.
#pragma once

#include <cstddef>
#include <vector>

namespace kinora {

/// Aligned to 64 bytes, from 1 MB on to 2 MB with a request for transparent huge pages (Linux: without them a look-up
/// here and there costs a page walk besides the cache miss). Throws std::bad_alloc.
void* allocate_large(std::size_t bytes);
void free_large(void* memory) noexcept;

template <class T> struct LargeAllocator {
  using value_type = T;
  LargeAllocator() = default;
  template <class U> LargeAllocator(const LargeAllocator<U>& /*other*/) noexcept {}
  T* allocate(std::size_t count) {
    if (count > static_cast<std::size_t>(-1) / sizeof(T)) throw std::bad_array_new_length();
    return static_cast<T*>(allocate_large(count * sizeof(T)));
  }
  void deallocate(T* memory, std::size_t /*count*/) noexcept { free_large(memory); }
  friend bool operator==(const LargeAllocator&, const LargeAllocator&) { return true; }
};

template <class T> using LargeBuffer = std::vector<T, LargeAllocator<T>>;

} // namespace kinora
