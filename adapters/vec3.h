// Vectors in space, and rows of arrays of three numbers.

#pragma once

#include <cmath>

namespace flipflow {

struct Vec3 {
  double x, y, z;
};

inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(double s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(Vec3 a) { return std::sqrt(dot(a, a)); }
inline Vec3 from(const double *p) { return {p[0], p[1], p[2]}; }
inline void put(double *p, Vec3 a) {
  p[0] = a.x;
  p[1] = a.y;
  p[2] = a.z;
}
inline void add_to(double *p, Vec3 a) {
  p[0] += a.x;
  p[1] += a.y;
  p[2] += a.z;
}

}  // namespace flipflow
