#pragma once

// Vectors as three numbers in a row.
namespace flipflow {

inline double dot(const double *a, const double *b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline void add(double factor, const double *vector, double *to) {
  for (int c = 0; c < 3; ++c) to[c] += factor * vector[c];
}

// Adds the part of a vector that is normal to the unit vector `n`.
inline void add_normal_part(double factor, const double *vector, const double *n, double *to) {
  add(factor, vector, to);
  add(-factor * dot(vector, n), n, to);
}

}  // namespace flipflow
