#pragma once

#include "arrays.h"

namespace flipflow {

// A body and the state that it works on, in arrays that Python owns: kept alive, and of the right
// size, which `state_of(body, arrays)` sees to.
template <class Body, class State>
class Bound {
 public:
  Bound(Body body, std::vector<Doubles> arrays)
      : body_(std::move(body)), arrays_(std::move(arrays)), state_(state_of(body_, arrays_)) {}

  const Body &body() const { return body_; }
  const State &state() const { return state_; }

  void rest() { body_.rest(state_); }

  // In steps to the end of an interval; returns the work on the held points in J.
  double advance(const Doubles &start_m, const Doubles &start_m_per_s, const Doubles &end_m,
                 const Doubles &end_m_per_s, const Doubles &outside_N, double length_s, int steps,
                 Doubles impulse_N_s) {
    const py::ssize_t held = 3 * body_.held();
    const HeldPath path = path_of(start_m, start_m_per_s, end_m, end_m_per_s, length_s, held);
    const double *force_N = of(outside_N, body_.size(), "outside_N");
    double *impulse = into(impulse_N_s, held, "impulse_N_s");
    py::gil_scoped_release others_may_run;
    return body_.advance(state_, path, force_N, steps, impulse);
  }

 private:
  Body body_;
  std::vector<Doubles> arrays_;
  State state_;
};

// Tells Python of what all bound bodies can do.
template <class BoundBody>
void add_motion(py::class_<BoundBody> &bound) {
  bound.def("rest", &BoundBody::rest)
      .def("advance", &BoundBody::advance, py::arg("start_m").noconvert(),
           py::arg("start_m_per_s").noconvert(), py::arg("end_m").noconvert(),
           py::arg("end_m_per_s").noconvert(), py::arg("outside_N").noconvert(), py::arg("length_s"),
           py::arg("steps"), py::arg("impulse_N_s").noconvert());
}

}  // namespace flipflow
