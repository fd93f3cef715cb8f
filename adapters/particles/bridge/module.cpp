// adapters.particles._liggghts: LIGGGHTS in this process, with our own surface.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <utility>

#include "atom.h"
#include "contact_energy.h"
#include "engine.h"
#include "lammps.h"
#include "state_arrays.h"

namespace py = pybind11;
using flipflow::Engine;

namespace {

using Doubles = py::array_t<double, py::array::c_style>;
using Ints = py::array_t<int, py::array::c_style>;

// LIGGGHTS's own memory as an array; valid until the next call that moves particles.
template <class T>
py::array_t<T> view(py::object engine, T *first, int rows) {
  static T none;
  return py::array_t<T>({rows}, first ? first : &none, engine);
}

py::array_t<double> view3(py::object engine, double **first, int rows) {
  static double none;
  return py::array_t<double>({rows, 3}, rows ? first[0] : &none, engine);
}

py::dict particles(py::object self) {
  LAMMPS_NS::Atom &atom = *self.cast<Engine &>().lammps().atom;
  const int n = atom.nlocal;
  py::dict arrays;
  arrays["x"] = view3(self, atom.x, n);
  arrays["v"] = view3(self, atom.v, n);
  arrays["omega"] = view3(self, atom.omega, n);
  arrays["f"] = view3(self, atom.f, n);
  arrays["torque"] = view3(self, atom.torque, n);
  arrays["radius"] = view(self, atom.radius, n);
  arrays["rmass"] = view(self, atom.rmass, n);
  arrays["density"] = view(self, atom.density, n);
  arrays["type"] = view(self, atom.type, n);
  arrays["tag"] = view(self, atom.tag, n);
  return arrays;
}

std::vector<flipflow::Triangle> corners_of(Ints triangles, int points) {
  std::vector<flipflow::Triangle> corners(triangles.shape(0));
  for (size_t t = 0; t < corners.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      corners[t][k] = triangles.at(t, k);
      if (corners[t][k] < 0 || corners[t][k] >= points)
        throw py::value_error("triangle " + std::to_string(t) + " names a point that is not there");
    }
  return corners;
}

void set_surface(Engine &engine, Doubles position_m, Ints triangles, Ints type,
                 double largest_radius_m) {
  std::vector<double> points(position_m.data(), position_m.data() + position_m.size());
  auto corners = corners_of(triangles, static_cast<int>(position_m.shape(0)));
  engine.surface().set_surface(flipflow::SurfacePath(std::move(points)), std::move(corners),
                               {type.data(), type.data() + type.size()}, largest_radius_m);
}

void create_particles(Engine &engine, Doubles position_m, Doubles velocity_m_per_s, Doubles spin_rad_per_s,
            Doubles diameter_m, Doubles density_kg_per_m3, Ints type, int first_id) {
  engine.create({position_m.data(), velocity_m_per_s.data(), spin_rad_per_s.data(), diameter_m.data(),
                 density_kg_per_m3.data(), type.data(), static_cast<int>(diameter_m.size())},
                first_id);
}

void repeat_surface(Engine &engine, double period_m, Ints joined) {
  engine.surface().repeat(period_m, corners_of(joined, engine.surface().points()));
}

void set_exits(Engine &engine, Doubles center_m, Doubles axes, Doubles half_m, Doubles domain_m) {
  std::vector<flipflow::FixExits::Box> boxes(half_m.shape(0));
  for (size_t e = 0; e < boxes.size(); ++e) {
    boxes[e].center = flipflow::from(center_m.data() + 3 * e);
    for (int k = 0; k < 3; ++k) {
      boxes[e].axis[k] = flipflow::from(axes.data() + 9 * e + 3 * k);
      boxes[e].half[k] = half_m.at(e, k);
    }
  }
  engine.exits().set(std::move(boxes), flipflow::from(domain_m.data()),
                     flipflow::from(domain_m.data() + 3));
}

// One value, or three, of each particle removed.
template <class Value, class Get>
py::array_t<Value> column(const std::vector<flipflow::FixExits::Removed> &rows, Get get) {
  py::array_t<Value> array(static_cast<py::ssize_t>(rows.size()));
  for (size_t i = 0; i < rows.size(); ++i) array.mutable_at(i) = get(rows[i]);
  return array;
}

template <class Get>
Doubles column3(const std::vector<flipflow::FixExits::Removed> &rows, Get get) {
  Doubles array({static_cast<py::ssize_t>(rows.size()), py::ssize_t{3}});
  for (size_t i = 0; i < rows.size(); ++i) flipflow::put(array.mutable_data(i, 0), get(rows[i]));
  return array;
}

py::dict take_removed(Engine &engine) {
  using Row = flipflow::FixExits::Removed;
  const auto rows = engine.exits().take();
  py::dict arrays;
  arrays["x"] = column3(rows, [](const Row &r) { return r.position_m; });
  arrays["v"] = column3(rows, [](const Row &r) { return r.velocity_m_per_s; });
  arrays["omega"] = column3(rows, [](const Row &r) { return r.spin_rad_per_s; });
  arrays["radius"] = column<double>(rows, [](const Row &r) { return r.radius_m; });
  arrays["rmass"] = column<double>(rows, [](const Row &r) { return r.mass_kg; });
  arrays["density"] = column<double>(rows, [](const Row &r) { return r.density_kg_per_m3; });
  arrays["type"] = column<int>(rows, [](const Row &r) { return r.type; });
  arrays["tag"] = column<int>(rows, [](const Row &r) { return r.tag; });
  arrays["exit"] = column<int>(rows, [](const Row &r) { return r.exit; });
  arrays["step"] = column<int>(rows, [&](const Row &r) {
    return static_cast<int>(r.step - engine.surface().first_step());
  });
  return arrays;
}

py::dict take_crossings(Engine &engine) {
  const auto rows = engine.surface().take_crossings();
  const auto count = static_cast<py::ssize_t>(rows.size());
  py::array_t<int> tag(count), step(count);
  Doubles position_m({count, py::ssize_t{3}});
  for (py::ssize_t k = 0; k < count; ++k) {
    tag.mutable_at(k) = rows[k].tag;
    step.mutable_at(k) = static_cast<int>(rows[k].step - engine.surface().first_step());
    flipflow::put(position_m.mutable_data(k, 0), rows[k].position_m);
  }
  py::dict arrays;
  arrays["tag"] = tag;
  arrays["step"] = step;
  arrays["x"] = position_m;
  return arrays;
}

void begin_path(Engine &engine, Doubles start_m, Doubles start_m_per_s, Doubles end_m,
                Doubles end_m_per_s, double length_s, int steps) {
  engine.surface().begin_path(start_m.data(), start_m_per_s.data(), end_m.data(), end_m_per_s.data(),
                              length_s, steps);
}

void run(Engine &engine, int steps, double step_s) {
  engine.surface().begin_sums(step_s);
  engine.run(steps, step_s);
  engine.surface().end_sums(step_s);
}

void set_laws(Engine &engine, std::vector<double> e_star_Pa, std::vector<double> g_star_Pa,
              bool tangential_spring, const std::string &adhesion, std::vector<double> strength) {
  flipflow::ContactLaws laws;
  laws.types = engine.lammps().atom->ntypes;
  laws.e_star_Pa = std::move(e_star_Pa);
  laws.g_star_Pa = std::move(g_star_Pa);
  laws.tangential_spring = tangential_spring;
  laws.adhesion = adhesion == "jkr"    ? flipflow::ContactLaws::Adhesion::jkr
                  : adhesion == "sjkr" ? flipflow::ContactLaws::Adhesion::sjkr
                                       : flipflow::ContactLaws::Adhesion::none;
  laws.strength = std::move(strength);
  engine.set_laws(laws);
}

// `rate_m3_per_N_m` by pair of types, row by row.
void set_wear(Engine &engine, std::vector<double> rate_m3_per_N_m) {
  const flipflow::ContactLaws &laws = engine.laws();
  flipflow::FixSurface &surface = engine.surface();
  surface.set_wear({std::move(rate_m3_per_N_m), laws.types, laws.spring(), surface.points()});
}

std::pair<double, double> pair_of(flipflow::ContactEnergy energy) {
  return {energy.elastic_J, energy.adhesion_J};
}

Doubles triple(flipflow::Vec3 value) {
  Doubles array(py::ssize_t{3});
  flipflow::put(array.mutable_data(), value);
  return array;
}

Doubles worn_m3(Engine &engine) {
  const std::vector<double> &worn = engine.surface().wear().worn_m3();
  return Doubles(static_cast<py::ssize_t>(worn.size()), worn.data());
}

// Particle-particle and surface contacts of all steps since this was last asked, on this rank: depth
// and its share of a diameter, of each.
py::tuple take_deepest_overlaps(Engine &engine) {
  const auto between = std::exchange(flipflow::deepest_between(engine.lammps()), {});
  const auto surface = engine.surface().take_deepest();
  return py::make_tuple(between.depth_m, between.share, surface.depth_m, surface.share);
}

Doubles by_point(const std::vector<double> &values) {
  Doubles array({static_cast<py::ssize_t>(values.size() / 3), py::ssize_t{3}});
  std::copy(values.begin(), values.end(), array.mutable_data());
  return array;
}

py::tuple response(Engine &engine, double length_s) {
  const size_t points = engine.surface().points();
  std::vector<double> push_N(3 * points, 0.0), impedance_N_s_per_m(9 * points, 0.0);
  engine.surface().response().respond(*engine.lammps().atom, length_s, push_N, impedance_N_s_per_m);
  return py::make_tuple(by_point(push_N), by_point(impedance_N_s_per_m));
}

}  // namespace

PYBIND11_MODULE(_liggghts, module) {
  py::class_<Engine>(module, "Engine")
      .def(py::init([](int communicator, const std::string &screen, const std::string &log,
                       double contact_distance_factor) {
             return std::make_unique<Engine>(MPI_Comm_f2c(communicator), screen, log,
                                             contact_distance_factor);
           }),
           py::arg("communicator"), py::arg("screen_file"), py::arg("log_file"),
           py::arg("contact_distance_factor"))
      .def("command", &Engine::command)
      .def("set_surface", &set_surface)
      .def("set_laws", &set_laws)
      .def("set_wear", &set_wear)
      .def("create", &create_particles)
      .def("repeat_surface", &repeat_surface)
      .def("set_exits", &set_exits)
      .def("take_removed", &take_removed)
      .def("overlaps",
           [](Engine &engine, Doubles position_m, Doubles diameter_m) {
             return engine.overlaps(position_m.data(), diameter_m.data(),
                                    static_cast<int>(diameter_m.size()));
           })
      .def("store_history", &Engine::store_history)
      .def("prepare", &Engine::prepare)
      .def("begin_path", &begin_path)
      .def("run", &run)
      .def("save", &flipflow::save)
      .def("restore", &flipflow::restore)
      .def("particles", &particles)
      .def("impulse_N_s", [](Engine &e) { return by_point(e.surface().load().impulse_N_s()); })
      .def("force_N", [](Engine &e) { return by_point(e.surface().load().force_N()); })
      .def("ask_response", [](Engine &e) { e.surface().response().ask(); })
      .def("response", &response)
      .def("worn_m3", &worn_m3)
      .def("angular_impulse_N_m_s",
           [](Engine &e) { return triple(e.surface().load().angular_impulse_N_m_s()); })
      .def("mass_moment_time_kg_m_s",
           [](Engine &e) { return triple(e.surface().mass_moment_time()); })
      .def("surface_work_J", [](Engine &e) { return e.surface().load().work_J(); })
      .def("surface_energy_J", [](Engine &e) { return pair_of(e.surface().energy()); })
      .def("take_deepest_overlaps", &take_deepest_overlaps)
      .def("take_crossings", &take_crossings)
      .def("surface_contacts", [](Engine &e) { return e.surface().contacts(); })
      .def("pair_energy_J",
           [](Engine &e) { return pair_of(flipflow::pair_energy(e.lammps(), e.laws())); });
}
