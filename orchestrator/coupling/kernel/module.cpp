// orchestrator.coupling._kernel: what the coupling computes at all points in every interval, bound to Python.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

// Loops over all points are compiled for several generations of x86-64; the one that fits is chosen when the
// module is loaded.
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__)
#define FLIPFLOW_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define FLIPFLOW_CLONES
#endif

namespace flipflow {

namespace {

namespace py = pybind11;

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Ints = py::array_t<int, py::array::c_style | py::array::forcecast>;

// The vectors at `points` points, (points, 3).
const double *vectors(const Doubles &array, size_t points, const char *name) {
  if (array.ndim() != 2 || array.shape(1) != 3 || static_cast<size_t>(array.shape(0)) != points)
    throw py::value_error(std::string(name) + ": shape (" + std::to_string(points) + ", 3) wanted");
  return array.data();
}

double size_of(const double *vector) {
  return std::abs(vector[0]) + std::abs(vector[1]) + std::abs(vector[2]);
}

bool is_zero(const double *vector) { return size_of(vector) == 0.0; }  // one branch instead of three

using Vec = std::array<double, 3>;

Vec operator+(const Vec &a, const Vec &b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }

Vec operator*(double factor, const Vec &a) { return {factor * a[0], factor * a[1], factor * a[2]}; }

double dot(const Vec &a, const Vec &b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vec cross(const Vec &a, const Vec &b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

void add(const Vec &value, double *to) {
  for (int c = 0; c < 3; ++c) to[c] += value[c];
}

// A sparse matrix that takes vectors at points to vectors at others: row i has the entries from
// starts[i] up to starts[i + 1].
class PointMatrix {
 public:
  PointMatrix(const Ints &starts, const Ints &columns, const Doubles &entries, size_t width)
      : starts_(starts.data(), starts.data() + starts.size()),
        columns_(columns.data(), columns.data() + columns.size()),
        entries_(entries.data(), entries.data() + entries.size()),
        width_(width) {
    if (starts_.empty() || starts_.front() != 0 || columns_.size() != entries_.size() ||
        starts_.back() != static_cast<int>(entries_.size()))
      throw py::value_error("starts, columns, entries: not a matrix by rows");
    for (size_t row = 0; row < rows(); ++row)
      if (starts_[row] > starts_[row + 1]) throw py::value_error("starts: not ascending");
    for (const int column : columns_)
      if (column < 0 || static_cast<size_t>(column) >= width_)
        throw py::value_error("columns: no column has the number " + std::to_string(column));
  }

  Doubles times(const Doubles &values) const {
    const double *from = vectors(values, width_, "values");
    Doubles product({rows(), size_t{3}});
    double *to = product.mutable_data();
    for (size_t row = 0; row < rows(); ++row, to += 3) {
      const auto [x, y, z] = row_times(row, from);
      to[0] = x, to[1] = y, to[2] = z;
    }
    return product;
  }

  // Of thousands of points most have no force, so that their rows need not be looked at.
  Doubles transposed_times(const Doubles &values) const {
    const double *from = vectors(values, rows(), "values");
    Doubles product({width_, size_t{3}});
    double *to = product.mutable_data();
    std::fill(to, to + 3 * width_, 0.0);
    for (size_t row = 0; row < rows(); ++row, from += 3) {
      if (!is_zero(from)) add_by_row(row, {from[0], from[1], from[2]}, to);
    }
    return product;
  }

  size_t rows() const { return starts_.size() - 1; }

  size_t width() const { return width_; }

  // The row times the vectors at `from`.
  Vec row_times(size_t row, const double *from) const {
    double x = 0.0, y = 0.0, z = 0.0;
    for (int i = starts_[row]; i < starts_[row + 1]; ++i) {
      const double *at = from + 3 * static_cast<size_t>(columns_[i]);
      x += entries_[i] * at[0];
      y += entries_[i] * at[1];
      z += entries_[i] * at[2];
    }
    return {x, y, z};
  }

  // Adds `value` times each entry of the row to the vector at `to` that the entry belongs to.
  void add_by_row(size_t row, const Vec &value, double *to) const {
    for (int i = starts_[row]; i < starts_[row + 1]; ++i) {
      double *at = to + 3 * static_cast<size_t>(columns_[i]);
      for (int c = 0; c < 3; ++c) at[c] += entries_[i] * value[c];
    }
  }

 private:
  std::vector<int> starts_, columns_;
  std::vector<double> entries_;
  size_t width_;
};

// The vectors at `points` points of an array that is changed in place.
double *changed_vectors(Doubles &array, size_t points, const char *name) {
  vectors(array, points, name);
  return array.mutable_data();
}

// Points that stand at an offset z from a surface along its normal n = a / |a|, a = (along x) x (across x),
// with the surface's own points at x: see `NormalOffsets` in _kernel.pyi.
class NormalOffsets {
 public:
  NormalOffsets(PointMatrix along, PointMatrix across, const Doubles &offset_m)
      : along_(std::move(along)),
        across_(std::move(across)),
        offset_m_(offset_m.data(), offset_m.data() + offset_m.size()) {
    if (along_.rows() != across_.rows() || along_.width() != across_.width() ||
        along_.rows() != offset_m_.size())
      throw py::value_error("along, across, offset_m: of different numbers of points");
    for (size_t point = 0; point < offset_m_.size(); ++point)
      if (offset_m_[point] != 0.0) beside_.push_back(point);
  }

  void add_motion(const Doubles &own_m, const Doubles &own_m_per_s, Doubles position_m,
                  Doubles velocity_m_per_s) const {
    const double *x = vectors(own_m, along_.width(), "own_m");
    const double *v = vectors(own_m_per_s, along_.width(), "own_m_per_s");
    double *place = changed_vectors(position_m, along_.rows(), "position_m");
    double *rate = changed_vectors(velocity_m_per_s, along_.rows(), "velocity_m_per_s");
    for (const size_t point : beside_) {
      const Normal at(*this, point, x);
      const Vec grown =
          cross(along_.row_times(point, v), at.across) + cross(at.along, across_.row_times(point, v));
      add(offset_m_[point] * at.unit, place + 3 * point);
      add(offset_m_[point] * at.turned_by(grown), rate + 3 * point);
    }
  }

  // The unit normal changes with its area vector by a symmetric projection, which therefore stands in the
  // transpose, too.
  void add_load(const Doubles &own_m, const Doubles &force_N, Doubles own_force_N) const {
    const double *x = vectors(own_m, along_.width(), "own_m");
    const double *force = vectors(force_N, along_.rows(), "force_N");
    double *to = changed_vectors(own_force_N, along_.width(), "own_force_N");
    for (const size_t point : beside_) {
      const double *f = force + 3 * point;
      if (is_zero(f)) continue;
      const Normal at(*this, point, x);
      const Vec turning = offset_m_[point] * at.turned_by({f[0], f[1], f[2]});
      along_.add_by_row(point, cross(at.across, turning), to);
      across_.add_by_row(point, cross(turning, at.along), to);
    }
  }

 private:
  // The normal at a point of the surface, and the slopes along and across that span the surface there.
  struct Normal {
    Vec along, across, unit;
    double size;

    Normal(const NormalOffsets &points, size_t point, const double *x)
        : along(points.along_.row_times(point, x)), across(points.across_.row_times(point, x)) {
      const Vec area = cross(along, across);
      size = std::sqrt(dot(area, area));
      unit = (1.0 / size) * area;
    }

    // How the unit normal changes with its area vector by `grown`.
    Vec turned_by(const Vec &grown) const {
      return (1.0 / size) * (grown + (-dot(unit, grown)) * unit);
    }
  };

  PointMatrix along_, across_;
  std::vector<double> offset_m_;
  std::vector<size_t> beside_;
};

Doubles field(const py::object &record, const char *name) {
  const py::object value = record.attr(name);
  return py::isinstance<Doubles>(value) ? py::reinterpret_borrow<Doubles>(value) : value.cast<Doubles>();
}

void add_handed_over(Doubles sums, const py::object &load, const py::object &start, const py::object &end,
                     double length_s) {
  if (sums.size() != 7) throw py::value_error("sums: 7 numbers wanted");
  const Doubles force_N = field(load, "force_N");
  const Doubles start_m = field(start, "position_m"), start_m_per_s = field(start, "velocity_m_per_s");
  const Doubles end_m = field(end, "position_m"), end_m_per_s = field(end, "velocity_m_per_s");
  const size_t points = force_N.shape(0);
  const double *force = vectors(force_N, points, "load.force_N");
  const double *from = vectors(start_m, points, "start.position_m");
  const double *from_rate = vectors(start_m_per_s, points, "start.velocity_m_per_s");
  const double *to = vectors(end_m, points, "end.position_m");
  const double *to_rate = vectors(end_m_per_s, points, "end.velocity_m_per_s");
  long double sum_N[3] = {};  // the clamps of a taut panel pull against each other: little is left
  double moment[3] = {}, size = 0.0;
  for (size_t i = 0; i < 3 * points; i += 3) {
    const double *f = force + i;
    if (is_zero(f)) continue;
    double mean_m[3];
    for (int c = 0; c < 3; ++c) {
      mean_m[c] = 0.5 * (from[i + c] + to[i + c]) + length_s / 12.0 * (from_rate[i + c] - to_rate[i + c]);
      sum_N[c] += f[c];
    }
    for (int c = 0; c < 3; ++c) {
      const int next = (c + 1) % 3, last = (c + 2) % 3;
      moment[c] += length_s * (mean_m[next] * f[last] - mean_m[last] * f[next]);
    }
    size += length_s * size_of(f);
  }
  double *total = sums.mutable_data();
  for (int c = 0; c < 3; ++c) {
    total[c] += static_cast<double>(length_s * sum_N[c]);
    total[3 + c] += moment[c];
  }
  total[6] += size;
}

// Sums of works in an interval, over coordinates of points: see `Works` in _kernel.pyi.
struct Works {
  double exchanged_J = 0.0, size_N = 0.0, created_J = 0.0, through_J = 0.0;

  py::tuple as_tuple() const { return py::make_tuple(exchanged_J, size_N, created_J, through_J); }
};

// Books the work of a load on coordinates that went from `before_m` to `after_m`, and its size.
FLIPFLOW_CLONES
void book_exchanged(Works &works, const double *load_N, const double *before_m, const double *after_m,
                   size_t coordinates) {
  double exchanged_J = 0.0, size_N = 0.0;
#pragma omp simd reduction(+ : exchanged_J, size_N)
  for (size_t i = 0; i < coordinates; ++i) {
    exchanged_J += load_N[i] * (after_m[i] - before_m[i]);
    size_N += std::abs(load_N[i]);
  }
  works.exchanged_J = exchanged_J, works.size_N = size_N;
}

// The vectors of a record's attribute, (points, 3), which live as long as `held`.
const double *read(std::vector<Doubles> &held, const py::object &record, const char *name, size_t points) {
  held.push_back(field(record, name));
  return vectors(held.back(), points, name);
}

// The coordinates of an interval between particles and panels: the load of the particles, now, before and
// twice before, and their path from `start_m`, after the one before it that ended at `left_m`; the panels'
// load, and where it found and left them.
struct Contact {
  const double *load_N, *load_before_N, *load_twice_before_N, *start_m, *end_m, *left_m;
  const double *panel_load_N, *before_m, *after_m;
};

FLIPFLOW_CLONES
void book_contact(Works &works, const Contact at, double least_m, size_t coordinates) {
  double created_J = 0.0, through_J = 0.0;
#pragma omp simd reduction(+ : created_J, through_J)
  for (size_t i = 0; i < coordinates; ++i) {
    const double moved_m = at.after_m[i] - at.before_m[i], jump_m = at.start_m[i] - at.left_m[i];
    const double jumps_N = (2 * at.load_N[i] + 5 * at.load_before_N[i] - at.load_twice_before_N[i]) * (1.0 / 6.0);
    created_J += at.panel_load_N[i] * moved_m - at.load_N[i] * (at.end_m[i] - at.start_m[i]) - jumps_N * jump_m;
    through_J += std::abs(at.load_N[i]) * (std::abs(moved_m) + least_m);
  }
  works.created_J = created_J, works.through_J = through_J;
}

py::list contact_works(const py::list &intervals, size_t counted, const Doubles &before_m,
                       const Doubles &path_before_m, const Doubles &load_before_N,
                       const Doubles &load_twice_before_N, double slow_m_per_s) {
  const size_t points = before_m.shape(0);
  if (counted > points) throw py::value_error("counted: more than there are points");
  Contact at;
  at.before_m = vectors(before_m, points, "before_m");
  at.left_m = vectors(path_before_m, points, "path_before_m");
  at.load_before_N = vectors(load_before_N, points, "load_before_N");
  at.load_twice_before_N = vectors(load_twice_before_N, points, "load_twice_before_N");
  std::vector<Doubles> held;
  py::list result;
  for (const py::handle interval : intervals) {
    const py::tuple particles = interval.attr("particles"), panel = interval.attr("panel");
    const double least_m = slow_m_per_s * interval.attr("length_s").cast<double>();
    at.load_N = read(held, particles[1], "force_N", points);
    at.start_m = read(held, particles[0].attr("start"), "position_m", points);
    at.end_m = read(held, particles[0].attr("end"), "position_m", points);
    at.panel_load_N = read(held, panel[1], "force_N", points);
    at.after_m = read(held, panel[2].attr("surface"), "position_m", points);
    Works works;
    book_exchanged(works, at.load_N, at.before_m, at.after_m, 3 * points);
    book_contact(works, at, least_m, 3 * counted);
    result.append(works.as_tuple());
    at.before_m = at.after_m, at.left_m = at.end_m;
    at.load_twice_before_N = at.load_before_N, at.load_before_N = at.load_N;
  }
  return result;
}

// The coordinates of an interval between panels and frames: the load on the frames, and where it found and
// left them; the panels' reaction, and where their clamps were told to go, now and before.
struct Clamping {
  const double *frames_load_N, *before_m, *after_m, *reaction_N, *target_m, *target_before_m;
};

FLIPFLOW_CLONES
void book_clamping(Works &works, const Clamping at, double least_m, size_t coordinates) {
  double created_J = 0.0, through_J = 0.0;
#pragma omp simd reduction(+ : created_J, through_J)
  for (size_t i = 0; i < coordinates; ++i) {
    const double moved_m = at.after_m[i] - at.before_m[i];
    const double missed_more_m = (at.after_m[i] - at.target_m[i]) - (at.before_m[i] - at.target_before_m[i]);
    created_J += (at.frames_load_N[i] - at.reaction_N[i]) * moved_m + at.reaction_N[i] * missed_more_m;
    through_J += std::abs(at.reaction_N[i]) * (std::abs(moved_m) + least_m);
  }
  works.created_J = created_J, works.through_J = through_J;
}

py::list clamp_works(const py::list &intervals, size_t counted, const Doubles &before_m,
                     const Doubles &target_before_m, double slow_m_per_s) {
  const size_t points = before_m.shape(0);
  if (counted > points) throw py::value_error("counted: more than there are points");
  Clamping at;
  at.before_m = vectors(before_m, points, "before_m");
  at.target_before_m = vectors(target_before_m, points, "target_before_m");
  std::vector<Doubles> held;
  py::list result;
  for (const py::handle interval : intervals) {
    const py::tuple frames = interval.attr("frames"), panel = interval.attr("panel");
    const double least_m = slow_m_per_s * interval.attr("length_s").cast<double>();
    at.frames_load_N = read(held, frames[0], "force_N", points);
    at.after_m = read(held, frames[1], "position_m", points);
    at.target_m = read(held, panel[0], "position_m", points);
    at.reaction_N = read(held, panel[2].attr("reaction"), "force_N", points);
    Works works;
    book_exchanged(works, at.reaction_N, at.before_m, at.after_m, 3 * points);
    book_clamping(works, at, least_m, 3 * counted);
    result.append(works.as_tuple());
    at.before_m = at.after_m, at.target_before_m = at.target_m;
  }
  return result;
}

// Adds up the squares of `now`, and finds the largest size of its second difference to the values before.
FLIPFLOW_CLONES
void find_size_and_change(const double *now, const double *before, const double *twice_before, size_t numbers,
                          double &squares, double &largest) {
  double sum = 0.0, most = 0.0;
#pragma omp simd reduction(+ : sum) reduction(max : most)
  for (size_t i = 0; i < numbers; ++i) {
    sum += now[i] * now[i];
    most = std::max(most, std::abs((now[i] - before[i]) - (before[i] - twice_before[i])));
  }
  squares = sum, largest = most;
}

py::list sizes_and_changes(const std::vector<Doubles> &values) {
  py::list result;
  for (size_t k = 2; k < values.size(); ++k) {
    const size_t points = values[k].shape(0);
    double squares, largest;
    find_size_and_change(vectors(values[k], points, "values"), vectors(values[k - 1], points, "values"),
                         vectors(values[k - 2], points, "values"), 3 * points, squares, largest);
    result.append(py::make_tuple(squares, largest));
  }
  return result;
}

}  // namespace

}  // namespace flipflow

PYBIND11_MODULE(_kernel, module) {
  using namespace flipflow;
  using py::arg;
  py::class_<PointMatrix>(module, "PointMatrix")
      .def(py::init<const Ints &, const Ints &, const Doubles &, size_t>(), arg("starts"), arg("columns"),
           arg("entries"), arg("width"))
      .def("times", &PointMatrix::times, arg("values"))
      .def("transposed_times", &PointMatrix::transposed_times, arg("values"));
  py::class_<NormalOffsets>(module, "NormalOffsets")
      .def(py::init<PointMatrix, PointMatrix, const Doubles &>(), arg("along"), arg("across"), arg("offset_m"))
      .def("add_motion", &NormalOffsets::add_motion, arg("own_m"), arg("own_m_per_s"),
           arg("position_m").noconvert(), arg("velocity_m_per_s").noconvert())
      .def("add_load", &NormalOffsets::add_load, arg("own_m"), arg("force_N"), arg("own_force_N").noconvert());
  module.def("add_handed_over", &add_handed_over, arg("sums").noconvert(), arg("load"), arg("start"), arg("end"),
             arg("length_s"));
  module.def("contact_works", &contact_works, arg("intervals"), py::kw_only(), arg("counted"), arg("before_m"),
             arg("path_before_m"), arg("load_before_N"), arg("load_twice_before_N"), arg("slow_m_per_s"));
  module.def("clamp_works", &clamp_works, arg("intervals"), py::kw_only(), arg("counted"), arg("before_m"),
             arg("target_before_m"), arg("slow_m_per_s"));
  module.def("sizes_and_changes", &sizes_and_changes, arg("values"));
}
