// Views of arrays that others own: N sizes, rows that may lie apart in memory, and numbers that follow each other in a
// row.

#pragma once

#include <array>
#include <cassert>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace holdfast {

using Int = std::int64_t;

template <class T, int N = 1>
class Span {
  public:
    Span() = default;
    Span(T* data, std::array<Int, N> sizes) : data_(data), sizes_(sizes) {
        Int step = 1;
        for (int i = N - 1; i >= 0; --i) {
            steps_[i] = step;
            step *= sizes[i];
        }
    }
    Span(T* data, std::array<Int, N> sizes, std::array<Int, N> steps) : data_(data), sizes_(sizes), steps_(steps) {}
    template <class S>
        requires(std::is_same_v<const S, T> && !std::is_same_v<S, T>)
    Span(const Span<S, N>& other) : data_(other.data()), sizes_(other.sizes()), steps_(other.steps()) {}

    T* data() const { return data_; }
    const std::array<Int, N>& sizes() const { return sizes_; }
    const std::array<Int, N>& steps() const { return steps_; }
    Int size() const { return sizes_[0]; }
    Int size(int axis) const { return sizes_[axis]; }

    // An entry, by as many indices as there are axes
    template <class... Index>
        requires(sizeof...(Index) == N)
    T& operator()(Index... index) const {
        const Int at[] = {static_cast<Int>(index)...};
        Int place = 0;
        for (int i = 0; i < N; ++i) {
            assert(at[i] >= 0 && at[i] < sizes_[i]);
            place += i == N - 1 ? at[i] : at[i] * steps_[i];
        }
        return data_[place];
    }

    // An entry of a vector, or what one index leaves of more axes
    decltype(auto) operator[](Int i) const {
        assert(i >= 0 && i < sizes_[0]);
        if constexpr (N == 1) {
            return (data_[i]);
        } else {
            std::array<Int, N - 1> sizes{}, steps{};
            for (int k = 1; k < N; ++k) {
                sizes[k - 1] = sizes_[k];
                steps[k - 1] = steps_[k];
            }
            return Span<T, N - 1>(data_ + i * steps_[0], sizes, steps);
        }
    }

    // Those from ``low`` on, or from there to ``high`` - 1, along the first axis
    Span from(Int low) const { return part(low, sizes_[0]); }
    Span part(Int low, Int high) const {
        assert(low >= 0 && low <= high && high <= sizes_[0]);
        Span found = *this;
        found.data_ += low * (N == 1 ? 1 : steps_[0]);
        found.sizes_[0] = high - low;
        return found;
    }

    void fill(T value) const {
        if constexpr (N == 1) {
            for (Int i = 0; i < sizes_[0]; ++i) data_[i] = value;
        } else {
            for (Int i = 0; i < sizes_[0]; ++i) (*this)[i].fill(value);
        }
    }

    T* begin() const
        requires(N == 1)
    {
        return data_;
    }
    T* end() const
        requires(N == 1)
    {
        return data_ + sizes_[0];
    }

  private:
    T* data_ = nullptr;
    std::array<Int, N> sizes_{};
    std::array<Int, N> steps_{};
};

// An array of its own: what a function makes and returns, or works in
template <class T, int N = 1>
struct Array {
    std::vector<T> numbers;
    std::array<Int, N> sizes{};

    Array() = default;
    explicit Array(std::array<Int, N> shape, T value = T()) : sizes(shape) {
        std::size_t count = 1;
        for (Int size : shape) count *= static_cast<std::size_t>(size);
        numbers.assign(count, value);
    }
    Span<T, N> view() { return Span<T, N>(numbers.data(), sizes); }
    Span<const T, N> view() const { return Span<const T, N>(numbers.data(), sizes); }
};

// An array that takes over these numbers
template <class T, std::size_t N>
Array<T, static_cast<int>(N)> array_of(std::vector<T>&& numbers, const std::array<Int, N>& sizes) {
    Array<T, static_cast<int>(N)> found;
    found.numbers = std::move(numbers);
    found.sizes = sizes;
    return found;
}

template <class T>
Array<T> array_of(std::vector<T>&& numbers) {
    const std::array<Int, 1> sizes{static_cast<Int>(numbers.size())};
    return array_of(std::move(numbers), sizes);
}

using Vec = Span<double>;  // written to
using Mat = Span<double, 2>;
using Ten = Span<double, 3>;
using In = Span<const double>;  // only read
using InMat = Span<const double, 2>;
using InTen = Span<const double, 3>;
using Ints = Span<Int>;
using IntMat = Span<Int, 2>;
using InInts = Span<const Int>;
using InIntMat = Span<const Int, 2>;

// What Python hands over is refused where it does not fit: this becomes a ValueError
inline void expect(bool holds, const char* what) {
    if (!holds) throw std::invalid_argument(std::string("expected ") + what);
}

// Indices of anything that there are ``count`` of; ``least`` is -1 where that stands for none
inline void expect_indices(InInts index, Int count, const char* what, Int least = 0) {
    for (Int i : index) expect(i >= least && i < count, what);
}

// Where each of several things begins among ``count`` others, and where the last one ends
inline void expect_begins(InInts first, Int things, Int count, const char* what) {
    expect(first.size() == things + 1 && first[0] == 0 && first[things] == count, what);
    for (Int i = 0; i < things; ++i) expect(first[i] <= first[i + 1], what);
}

}  // namespace holdfast
