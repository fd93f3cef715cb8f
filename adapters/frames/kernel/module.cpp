// adapters.frames._kernel: what frames compute around their solver's steps, bound to Python.

#include "../../kernel_arguments.h"
#include "spatial.h"

namespace flipflow {

namespace {

// Bodies and the state that they work on: pointers into `arrays`.
struct BoundBodies {
  SpatialBodies bodies;
  std::vector<Doubles> arrays;

  py::ssize_t six() const { return 6 * bodies.bodies(); }
  py::ssize_t points() const { return 3 * bodies.carried(); }

  void start(const Doubles &coordinates, const Doubles &rates) {
    bodies.start(of(coordinates, six(), "coordinates"), of(rates, six(), "rates"));
  }

  Doubles wrench_of(const Doubles &force_N, double length_s) const {
    Doubles wrench({bodies.bodies(), size_t{6}});
    bodies.wrench_of(of(force_N, points(), "force_N"), length_s, wrench.mutable_data());
    return wrench;
  }

  void apply(const Doubles &wrench, Doubles acceleration) {
    bodies.apply(of(wrench, six(), "wrench"), into(acceleration, six(), "acceleration"));
  }

  py::tuple coming_loads(double end_s) {
    Doubles exciter_N({bodies.exciters(), size_t{3}}), torque_N_m({bodies.bodies(), size_t{3}});
    bodies.coming_loads(end_s, exciter_N.mutable_data(), torque_N_m.mutable_data());
    return py::make_tuple(exciter_N, torque_N_m);
  }

  void reach(const Doubles &coordinates, const Doubles &rates) {
    bodies.reach(of(coordinates, six(), "coordinates"), of(rates, six(), "rates"));
  }

  py::dict book(double step_s) { return by_name(bodies.book(step_s)); }

  py::tuple carry() const {
    Doubles position_m({bodies.carried(), size_t{3}}), velocity_m_per_s({bodies.carried(), size_t{3}});
    bodies.carry(position_m.mutable_data(), velocity_m_per_s.mutable_data());
    return py::make_tuple(position_m, velocity_m_per_s);
  }

  py::dict reaction(const Doubles &force_N, const Doubles &before_m, const Doubles &after_m,
                    double length_s) const {
    return by_name(bodies.reaction(of(force_N, points(), "force_N"), of(before_m, points(), "before_m"),
                                   of(after_m, points(), "after_m"), length_s));
  }

  static py::dict by_name(const SpatialBooks &books) {
    Doubles outside_N_s(3);
    put(outside_N_s.mutable_data(), 0, books.outside_N_s);
    py::dict named;
    named["outside_N_s"] = outside_N_s;
    named["damping_J"] = books.damping_J;
    named["exciter_J"] = books.exciter_J;
    named["reaction_J"] = books.reaction_J;
    named["pushed_J"] = books.pushed_J;
    return named;
  }
};

AttachedPoints attached(Arguments &from, const std::string &name, size_t bodies) {
  AttachedPoints points;
  points.body = from.copied<int>((name + "_body").c_str());
  points.arm_m = from.copied((name + "_arm_m").c_str(), 3 * points.size());
  for (const int body : points.body)
    if (body < -1 || body >= static_cast<int>(bodies))
      throw py::value_error(name + "_body: no body has the number " + std::to_string(body));
  return points;
}

BoundBodies bind_bodies(py::kwargs given) {
  Arguments from(std::move(given));
  SpatialParts parts;
  parts.mass_kg = from.copied("mass_kg");
  const size_t bodies = parts.bodies();
  parts.drawn_m = from.copied("drawn_m", 3 * bodies);
  parts.inertia_kg_m2 = from.copied("inertia_kg_m2", 9 * bodies);
  parts.gravity_m_per_s2 = from.copied("gravity_m_per_s2", 3);
  parts.is_free = from.copied<int>("is_free");
  parts.is_driven = from.copied<int>("is_driven");
  if (parts.is_free.size() != bodies || parts.is_driven.size() != bodies)
    throw py::value_error("is_free, is_driven: one number for each body wanted");
  parts.first = attached(from, "first", bodies);
  parts.second = attached(from, "second", bodies);
  const size_t bushings = parts.bushings();
  if (parts.second.size() != bushings) throw py::value_error("second_body: as many as first_body wanted");
  parts.axes = from.copied("axes", 9 * bushings);
  parts.stiffness_N_per_m = from.copied("stiffness_N_per_m", 3 * bushings);
  parts.damping_N_s_per_m = from.copied("damping_N_s_per_m", 3 * bushings);
  parts.sag_m = from.copied("sag_m", 3 * bushings);
  parts.excited = attached(from, "excited", bodies);
  const size_t exciters = parts.exciters();
  parts.mass_moment_kg_m = from.copied("mass_moment_kg_m", exciters);
  parts.start = from.copied("start", 3 * exciters);
  parts.across = from.copied("across", 3 * exciters);
  parts.speed_rad_per_s = from.copied("speed_rad_per_s", exciters);
  parts.run_up_s = from.copied("run_up_s", exciters);
  parts.start_s = from.copied("start_s", exciters);
  parts.stop_s = from.copied("stop_s", exciters);
  parts.run_down_s = from.copied("run_down_s", exciters);
  parts.phase_rad = from.copied("phase_rad", exciters);
  parts.carried = attached(from, "carried", bodies);
  SpatialState state;
  state.center_m = from.state("center_m", 3 * bodies + 3);
  state.rotation = from.state("rotation", 9 * bodies + 9);
  state.velocity_m_per_s = from.state("velocity_m_per_s", 3 * bodies + 3);
  state.spin_rad_per_s = from.state("spin_rad_per_s", 3 * bodies + 3);
  state.spin_per_rate = from.state("spin_per_rate", 9 * bodies);
  state.stretch_m = from.state("stretch_m", 3 * bushings);
  state.stretch_m_per_s = from.state("stretch_m_per_s", 3 * bushings);
  state.element_N = from.state("element_N", 3 * bushings);
  state.pull_N = from.state("pull_N", 3 * bushings);
  state.from_m = from.state("from_m", 3 * bushings);
  state.to_m = from.state("to_m", 3 * bushings);
  state.couple_N_m = from.state("couple_N_m", 3 * bodies);
  state.couple_before_N_m = from.state("couple_before_N_m", 3 * bodies);
  state.exciter_N = from.state("exciter_N", 3 * exciters);
  state.exciter_m = from.state("exciter_m", 3 * exciters);
  state.wrench = from.state("wrench", 6 * bodies);
  from.check_all_taken();
  return {SpatialBodies(std::move(parts), state), std::move(from.arrays)};
}

}  // namespace

}  // namespace flipflow

PYBIND11_MODULE(_kernel, module) {
  using namespace flipflow;
  const auto array = [](const char *name) { return py::arg(name).noconvert(); };
  py::class_<BoundBodies>(module, "SpatialBodies")
      .def(py::init(&bind_bodies))
      .def("start", &BoundBodies::start, py::kw_only(), array("coordinates"), array("rates"))
      .def("wrench_of", &BoundBodies::wrench_of, py::kw_only(), array("force_N"), py::arg("length_s"))
      .def("apply", &BoundBodies::apply, py::kw_only(), array("wrench"), array("acceleration"))
      .def("coming_loads", &BoundBodies::coming_loads, py::kw_only(), py::arg("end_s"))
      .def("reach", &BoundBodies::reach, py::kw_only(), array("coordinates"), array("rates"))
      .def("book", &BoundBodies::book, py::kw_only(), py::arg("step_s"))
      .def("carry", &BoundBodies::carry)
      .def("reaction", &BoundBodies::reaction, py::kw_only(), array("force_N"), array("before_m"),
           array("after_m"), py::arg("length_s"));
}
