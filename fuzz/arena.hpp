// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// An allocator for the lists of the judges, many of which live as long as one call. Under AddressSanitizer the heap
// would record a stack for each list. An access beyond a list or after its end is found as in the heap.
#pragma once

#include <cstddef>
#include <functional>
#include <new>

#if __has_include(<sanitizer/asan_interface.h>)
#include <sanitizer/asan_interface.h>
#else
#define ASAN_POISON_MEMORY_REGION(from, size) (void)0
#define ASAN_UNPOISON_MEMORY_REGION(from, size) (void)0
#endif

namespace fuzz {

/// One block of memory. It gives pieces in ascending order, and begins anew once all of them were given back, so
/// that nothing lasts from one input to the next. A piece that does not fit comes from the heap.
class arena {
  public:
    arena() { ASAN_POISON_MEMORY_REGION(block_, capacity); }
    arena(const arena&) = delete;
    arena& operator=(const arena&) = delete;

    void* give(std::size_t size) {
        const std::size_t room = room_for(size);
        if (room > capacity - used_) return ::operator new(size);
        std::byte* const piece = block_ + used_;
        used_ += room;
        ++pieces_;
        ASAN_UNPOISON_MEMORY_REGION(piece, size);
        return piece;
    }
    void take_back(void* piece, std::size_t size) {
        auto* const from = static_cast<std::byte*>(piece);
        if (!is_inside(from)) return ::operator delete(piece);
        ASAN_POISON_MEMORY_REGION(piece, size);
        if (from + room_for(size) == block_ + used_) used_ -= room_for(size); // the newest one
        if (--pieces_ == 0) used_ = 0;
    }

  private:
    static constexpr std::size_t capacity = std::size_t{1} << 20;
    static constexpr std::size_t border = 16; ///< bytes after a piece that nothing may access

    static constexpr std::size_t room_for(std::size_t size) { return (size + border + 15) / 16 * 16; }
    bool is_inside(const std::byte* piece) const {
        return !std::less<>{}(piece, block_) && std::less<>{}(piece, block_ + capacity);
    }

    alignas(16) std::byte block_[capacity];
    std::size_t used_ = 0;
    std::size_t pieces_ = 0;
};

inline arena lists;

template <class T> struct allocator {
    using value_type = T;

    allocator() = default;
    template <class Other> allocator(const allocator<Other>&) {}

    T* allocate(std::size_t count) { return static_cast<T*>(lists.give(count * sizeof(T))); }
    void deallocate(T* first, std::size_t count) { lists.take_back(first, count * sizeof(T)); }
    friend bool operator==(const allocator&, const allocator&) { return true; }
};

} // namespace fuzz
