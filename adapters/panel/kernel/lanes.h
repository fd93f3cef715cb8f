#pragma once

#include <cstring>

// Loops that are worth it are compiled for several generations of x86-64; the one that fits is
// chosen when the module is loaded.  Everything they call must be FLIPFLOW_INLINE.
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__)
#define FLIPFLOW_CLONES \
  __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define FLIPFLOW_CLONES
#endif
#define FLIPFLOW_INLINE inline __attribute__((always_inline))

namespace flipflow {

// As many numbers side by side as the widest registers hold; narrower ones take several each.
// Aligned alike for all of them.
constexpr int kLanes = 8, kLanesBytes = kLanes * sizeof(double);
typedef double Lanes __attribute__((vector_size(kLanesBytes), aligned(kLanesBytes)));

struct LaneSum {  // for containers, which drop the alignment of a plain vector type
  Lanes value = {};
};

FLIPFLOW_INLINE Lanes load(const double *from) {
  Lanes value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

FLIPFLOW_INLINE void store(double *to, Lanes value) { std::memcpy(to, &value, sizeof value); }

inline double sum(Lanes value) {
  double total = 0.0;
  for (int lane = 0; lane < kLanes; ++lane) total += value[lane];
  return total;
}

}  // namespace flipflow
