#include "core/large_buffer.h"

#include <cstdlib>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace kinora {

void* allocate_large(std::size_t bytes) {
  constexpr std::size_t kLine = 64;
#ifdef __linux__
  constexpr std::size_t kPage = std::size_t{2} << 20;
  const std::size_t alignment = bytes >= kPage / 2 ? kPage : kLine;
#else
  const std::size_t alignment = kLine;
#endif
  if (bytes > static_cast<std::size_t>(-1) - alignment) throw std::bad_alloc();
  const std::size_t size = (bytes + alignment - 1) / alignment * alignment;
  void* memory = std::aligned_alloc(alignment, size);
  if (memory == nullptr && size > 0) throw std::bad_alloc();
#ifdef __linux__
  if (alignment > kLine) madvise(memory, size, MADV_HUGEPAGE); // a wish: what follows works without
#endif
  return memory;
}

void free_large(void* memory) noexcept { std::free(memory); }

} // namespace kinora
