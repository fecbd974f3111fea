// What Python hands over, as plain views: arrays by the buffer protocol, and named tuples of arrays as structs.
//
// An array must have the type and the number of axes of its view, and numbers that follow each other along its last
// axis; one that is written to must be writable. Nothing is converted or copied: it is a TypeError if an array does not
// fit. The caller holds all of them until the call returns.
//
// A struct names its members in the order of the named tuple:
//
//     struct Bed {
//         In x, y;
//         double mu;
//         static constexpr auto fields = std::tuple{&Bed::x, &Bed::y, &Bed::mu};
//     };

#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>

#include <array>
#include <new>
#include <tuple>
#include <utility>
#include <vector>

#include "span.hpp"

namespace holdfast {

template <class T>
concept Record = requires { T::fields; };

template <class T>
constexpr bool has_format(const char* format) {
    if (format == nullptr) return std::is_same_v<T, unsigned char>;
    if (*format == '<' || *format == '=' || *format == '@') ++format;
    if (format[0] == 0 || format[1] != 0) return false;
    if constexpr (std::is_same_v<T, double>) return *format == 'd';
    if constexpr (std::is_same_v<T, Int>) return *format == 'q' || (*format == 'l' && sizeof(long) == sizeof(Int));
    if constexpr (std::is_same_v<T, std::int32_t>) return *format == 'i' || (*format == 'l' && sizeof(long) == 4);
    if constexpr (std::is_same_v<T, unsigned char>) return *format == 'B' || *format == '?';
    if constexpr (std::is_same_v<T, bool>) return *format == '?';
    return false;
}

// View an array as T along N axes; false, without an error set, where it does not fit
template <class T, int N>
bool view_of(PyObject* source, Span<T, N>& into) noexcept {
    Py_buffer view;
    if (!PyObject_CheckBuffer(source) ||
        PyObject_GetBuffer(source, &view, PyBUF_FORMAT | PyBUF_STRIDES | (std::is_const_v<T> ? 0 : PyBUF_WRITABLE)) !=
            0) {
        PyErr_Clear();
        return false;
    }
    constexpr auto bytes = static_cast<Py_ssize_t>(sizeof(T));
    bool fits = view.ndim == N && view.itemsize == bytes && has_format<std::remove_const_t<T>>(view.format);
    std::array<Int, N> sizes{}, steps{};
    bool empty = false;
    for (int i = 0; fits && i < N; ++i) {
        sizes[i] = view.shape[i];
        empty = empty || sizes[i] == 0;
    }
    for (int i = 0; fits && !empty && i < N; ++i) {
        steps[i] = view.strides[i] / bytes;
        fits = view.strides[i] % bytes == 0 && (i < N - 1 || sizes[i] == 1 || steps[i] == 1);
    }
    if (fits) into = Span<T, N>(static_cast<T*>(view.buf), sizes, steps);
    PyBuffer_Release(&view);
    return fits;
}

}  // namespace holdfast

#define HOLDFAST_SPAN holdfast::Span<T, N>  // a macro takes no comma
#define HOLDFAST_ARRAY holdfast::Array<T, N>

namespace nanobind::detail {

template <class T>
constexpr auto number_name() {
    using Number = std::remove_const_t<T>;
    if constexpr (std::is_same_v<Number, double>)
        return const_name("numpy.float64");
    else if constexpr (std::is_same_v<Number, holdfast::Int>)
        return const_name("numpy.int64");
    else
        return const_name("typing.Any");
}

template <class T, int N>
struct type_caster<holdfast::Span<T, N>> {
    NB_TYPE_CASTER(HOLDFAST_SPAN, const_name("numpy.typing.NDArray[") + number_name<T>() + const_name("]"))
    bool from_python(handle source, std::uint32_t, cleanup_list*) noexcept {
        return holdfast::view_of(source.ptr(), value);
    }
    static handle from_cpp(const holdfast::Span<T, N>&, rv_policy, cleanup_list*) noexcept { return {}; }
};

// What a function returns becomes a NumPy array, which owns it
template <class T, int N>
struct type_caster<holdfast::Array<T, N>> {
    NB_TYPE_CASTER(HOLDFAST_ARRAY, const_name("numpy.typing.NDArray[") + number_name<T>() + const_name("]"))
    bool from_python(handle, std::uint32_t, cleanup_list*) noexcept { return false; }
    static handle from_cpp(const holdfast::Array<T, N>& source, rv_policy policy, cleanup_list* list) noexcept {
        return from_cpp(holdfast::Array<T, N>(source), policy, list);
    }
    static handle from_cpp(holdfast::Array<T, N>&& source, rv_policy, cleanup_list* list) noexcept {
        using Returned = ndarray<numpy, T, ndim<N>>;
        auto* kept = new (std::nothrow) holdfast::Array<T, N>(std::move(source));
        if (kept == nullptr) return PyErr_NoMemory();
        capsule owner(kept, [](void* all) noexcept { delete static_cast<holdfast::Array<T, N>*>(all); });
        std::size_t shape[N];
        for (int i = 0; i < N; ++i) shape[i] = static_cast<std::size_t>(kept->sizes[i]);
        return make_caster<Returned>::from_cpp(Returned(kept->numbers.data(), N, shape, owner), rv_policy::reference,
                                               list);
    }
};

template <holdfast::Record T>
struct type_caster<T> {
    NB_TYPE_CASTER(T, const_name("tuple[typing.Any, ...]"))
    bool from_python(handle source, std::uint32_t flags, cleanup_list* cleanup) noexcept {
        constexpr auto count = std::tuple_size_v<decltype(T::fields)>;
        if (!PyTuple_Check(source.ptr()) || static_cast<std::size_t>(PyTuple_Size(source.ptr())) != count) return false;
        return [&]<std::size_t... I>(std::index_sequence<I...>) {
            return (one<I>(source, flags, cleanup) && ...);
        }(std::make_index_sequence<count>{});
    }
    static handle from_cpp(const T&, rv_policy, cleanup_list*) noexcept { return {}; }

  private:
    template <std::size_t I>
    bool one(handle source, std::uint32_t flags, cleanup_list* cleanup) noexcept {
        auto& member = value.*std::get<I>(T::fields);
        using Member = std::remove_reference_t<decltype(member)>;
        make_caster<Member> caster;
        if (!caster.from_python(PyTuple_GetItem(source.ptr(), static_cast<Py_ssize_t>(I)), flags, cleanup))
            return false;
        member = static_cast<Member>(caster.operator cast_t<Member>());
        return true;
    }
};

}  // namespace nanobind::detail
