#pragma once

#include <cstring>

// Loops that are worth it are compiled for several generations of x86-64; the one that fits is
// chosen when the module is loaded.  All that they call must be FLIPFLOW_INLINE.
#define FLIPFLOW_INLINE inline __attribute__((always_inline))
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__)
#define FLIPFLOW_SEVERAL
#define FLIPFLOW_V4 __attribute__((target("arch=x86-64-v4")))  // registers of eight doubles
#define FLIPFLOW_V3 __attribute__((target("arch=x86-64-v3")))  // of four
#define FLIPFLOW_CLONES \
  __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define FLIPFLOW_V4
#define FLIPFLOW_V3
#define FLIPFLOW_CLONES
#endif

namespace flipflow {

// Arrays stand in groups of as many numbers as the widest registers hold; narrower ones take a
// group in several parts.
constexpr int kLanes = 8;

template <int count>
struct Register {
  typedef double type __attribute__((vector_size(count * sizeof(double))));
};
using Eight = Register<8>::type;
using Four = Register<4>::type;
using Two = Register<2>::type;

template <class V>
constexpr int kWidth = sizeof(V) / sizeof(double);

template <class V>
FLIPFLOW_INLINE V load(const double *from) {
  V value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

template <class V>
FLIPFLOW_INLINE void store(double *to, V value) {
  std::memcpy(to, &value, sizeof value);
}

template <class V>
FLIPFLOW_INLINE void add_to(double *to, V value) {
  store(to, load<V>(to) + value);
}

// Keeps a value in its register.  The compiler would read it from memory again at each use, since that takes no
// instruction of its own; but it takes time in a loop that reads nearly as often as it computes.
template <class V>
FLIPFLOW_INLINE void keep(V &value) {
#ifdef FLIPFLOW_SEVERAL
  asm("" : "+v"(value));
#else
  (void)value;
#endif
}

// Of three versions of a function the one for this processor.
template <class Function>
Function *fitting(Function *v4, Function *v3, Function *any) {
#ifdef FLIPFLOW_SEVERAL
  __builtin_cpu_init();
  if (__builtin_cpu_supports("x86-64-v4")) return v4;
  if (__builtin_cpu_supports("x86-64-v3")) return v3;
#else
  (void)v4, (void)v3;
#endif
  return any;
}

}  // namespace flipflow
