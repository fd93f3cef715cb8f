// adapters.particles._liggghts: LIGGGHTS in this process, with our own surface.
//
// Arrays come and go by name: every function that takes more than one argument takes them by
// keyword alone, never converts an array, and names the one whose shape is not what it should be.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "atom.h"
#include "contact_energy.h"
#include "engine.h"
#include "lammps.h"
#include "rebound.h"

namespace py = pybind11;
using namespace py::literals;
using flipflow::Engine;

namespace {

using Doubles = py::array_t<double, py::array::c_style>;
using Ints = py::array_t<int, py::array::c_style>;

constexpr py::ssize_t kAny = -1;  // any number of rows

std::string written(const std::vector<py::ssize_t> &shape) {
  std::string text;
  for (const py::ssize_t size : shape)
    text += (text.empty() ? "" : ", ") + (size == kAny ? "n" : std::to_string(size));
  return "(" + text + ")";
}

void check_shape(const char *name, const py::array &array, const std::vector<py::ssize_t> &wanted) {
  const std::vector<py::ssize_t> shape(array.shape(), array.shape() + array.ndim());
  bool right = shape.size() == wanted.size();
  for (size_t k = 0; right && k < shape.size(); ++k)
    right = wanted[k] == kAny || shape[k] == wanted[k];
  if (!right)
    throw py::value_error(std::string(name) + ": an array of shape " + written(wanted) +
                          " is wanted, got " + written(shape));
}

template <class Value>
std::vector<Value> values_of(const py::array_t<Value, py::array::c_style> &array) {
  return {array.data(), array.data() + array.size()};
}

template <class Value>
py::array_t<Value> array_of(const std::vector<Value> &values, const std::vector<py::ssize_t> &shape) {
  py::array_t<Value> array(shape);
  std::copy(values.begin(), values.end(), array.mutable_data());
  return array;
}

Doubles by_point(const std::vector<double> &values) {
  return array_of(values, {static_cast<py::ssize_t>(values.size() / 3), 3});
}

Doubles triple(flipflow::Vec3 value) {
  return array_of(std::vector<double>{value.x, value.y, value.z}, {3});
}

// LIGGGHTS's own memory as arrays; valid until the next call that moves particles.
py::dict particles(py::object self) {
  LAMMPS_NS::Atom &atom = *self.cast<Engine &>().lammps().atom;
  const int n = atom.nlocal;
  const auto column = [&](auto *first) {
    using Value = std::remove_pointer_t<decltype(first)>;
    static Value none;
    return py::array_t<Value>({n}, first ? first : &none, self);
  };
  const auto column3 = [&](double **first) {
    static double none;
    return py::array_t<double>({n, 3}, n ? first[0] : &none, self);
  };
  return py::dict("x"_a = column3(atom.x), "v"_a = column3(atom.v), "omega"_a = column3(atom.omega),
                  "f"_a = column3(atom.f), "torque"_a = column3(atom.torque),
                  "radius"_a = column(atom.radius), "rmass"_a = column(atom.rmass),
                  "density"_a = column(atom.density), "type"_a = column(atom.type),
                  "tag"_a = column(atom.tag));
}

// This rank's bodies, whose arrays have the names of those of single spheres; copies.
template <class Get>
Doubles table_of(int count, int columns, Get get) {
  Doubles array({static_cast<py::ssize_t>(count), static_cast<py::ssize_t>(columns)});
  for (int b = 0; b < count; ++b) get(b, array.mutable_data(b, 0));
  return array;
}

py::dict bodies(Engine &engine) {
  using flipflow::put;
  const flipflow::FixBodies &all = *engine.bodies();
  const LAMMPS_NS::Atom &atom = *engine.lammps().atom;
  const int n = all.count();
  const auto number = [&](auto get) {
    std::vector<double> values(n);
    for (int b = 0; b < n; ++b) values[b] = get(b);
    return array_of(values, {n});
  };
  const auto whole = [&](auto get) {
    std::vector<int> values(n);
    for (int b = 0; b < n; ++b) values[b] = static_cast<int>(get(b));
    return array_of(values, {n});
  };
  const auto vectors = [&](auto get) {
    return table_of(n, 3, [&](int b, double *row) { put(row, get(b)); });
  };
  return py::dict("tag"_a = whole([&](int b) { return all.row(b).id; }),
                  "shape"_a = whole([&](int b) { return all.row(b).shape; }),
                  "type"_a = whole([&](int b) { return atom.type[all.lead(b)]; }),
                  "size"_a = number([&](int b) { return all.row(b).size_m; }),
                  "density"_a = number([&](int b) { return atom.density[all.lead(b)]; }),
                  "rmass"_a = number([&](int b) { return all.mass_kg(b); }),
                  "x"_a = vectors([&](int b) { return all.row(b).place; }),
                  "v"_a = vectors([&](int b) { return all.row(b).velocity; }),
                  "omega"_a = vectors([&](int b) { return all.spin(b); }),
                  "f"_a = vectors([&](int b) { return all.force_N(b); }),
                  "angular_momentum"_a = vectors([&](int b) { return all.row(b).momentum; }),
                  "turn"_a = table_of(n, 4, [&](int b, double *row) { std::copy_n(all.row(b).turn, 4, row); }));
}

void set_shapes(Engine &engine, const Ints &count, const Doubles &spheres, const Doubles &volume,
                const Doubles &inertia, const Doubles &bounding_radius, double reach_m) {
  check_shape("count", count, {kAny});
  check_shape("spheres", spheres, {kAny, 4});
  check_shape("volume", volume, {count.size()});
  check_shape("inertia", inertia, {count.size(), 3});
  check_shape("bounding_radius", bounding_radius, {count.size()});
  std::vector<flipflow::BodyShape> shapes(count.size());
  py::ssize_t sphere = 0;
  for (size_t s = 0; s < shapes.size(); ++s) {
    for (int k = 0; k < count.at(s); ++k, ++sphere)
      shapes[s].spheres.push_back({flipflow::from(spheres.data(sphere, 0)), spheres.at(sphere, 3)});
    shapes[s].volume = volume.at(s);
    shapes[s].bounding_radius = bounding_radius.at(s);
    std::copy_n(inertia.data(s, 0), 3, shapes[s].inertia);
    for (int k = 0; k < 3; ++k) shapes[s].per_inertia[k] = 1.0 / shapes[s].inertia[k];
  }
  engine.set_shapes(std::move(shapes), reach_m);
}

std::vector<flipflow::Triangle> corners_of(const char *name, const Ints &triangles, int points) {
  check_shape(name, triangles, {kAny, 3});
  std::vector<flipflow::Triangle> corners(triangles.shape(0));
  for (size_t t = 0; t < corners.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      corners[t][k] = triangles.at(t, k);
      if (corners[t][k] < 0 || corners[t][k] >= points)
        throw py::value_error("triangle " + std::to_string(t) + " names a point that is not there");
    }
  return corners;
}

void set_surface(Engine &engine, const Doubles &position_m, const Ints &rigid_first, const Doubles &rigid_share,
                 const Ints &triangles, const Ints &type, double largest_radius_m) {
  check_shape("position_m", position_m, {kAny, 3});
  check_shape("rigid_first", rigid_first, {kAny});
  check_shape("rigid_share", rigid_share, {rigid_first.size(), 3});
  check_shape("type", type, {triangles.shape(0)});
  std::vector<flipflow::RigidVertex> rigid;
  for (py::ssize_t v = 0; v < rigid_first.size(); ++v) {
    const int first = rigid_first.at(v);
    const double *share = rigid_share.data(v, 0), rest = 1.0 - share[0] - share[1] - share[2];
    if (first < 0 || first + 4 > position_m.shape(0))
      throw py::value_error("rigid_first: vertex " + std::to_string(v) + " hangs on points that are not there");
    rigid.push_back({first, {rest, share[0], share[1], share[2]}});
  }
  flipflow::SurfacePath surface(values_of(position_m), std::move(rigid));
  auto corners = corners_of("triangles", triangles, surface.vertices());
  engine.surface().set_surface(std::move(surface), std::move(corners),
                               {type.data(), type.data() + type.size()}, largest_radius_m);
}

Engine::Particles checked(const Doubles &position_m, const Doubles &velocity_m_per_s,
                          const Doubles &spin_rad_per_s, const Doubles &diameter_m,
                          const Doubles &density_kg_per_m3, const Ints &type) {
  check_shape("position_m", position_m, {kAny, 3});
  const py::ssize_t count = position_m.shape(0);
  check_shape("velocity_m_per_s", velocity_m_per_s, {count, 3});
  check_shape("spin_rad_per_s", spin_rad_per_s, {count, 3});
  check_shape("diameter_m", diameter_m, {count});
  check_shape("density_kg_per_m3", density_kg_per_m3, {count});
  check_shape("type", type, {count});
  return {position_m.data(), velocity_m_per_s.data(), spin_rad_per_s.data(), diameter_m.data(),
          density_kg_per_m3.data(), type.data(), static_cast<int>(count)};
}

void create_particles(Engine &engine, const Doubles &position_m, const Doubles &velocity_m_per_s,
                      const Doubles &spin_rad_per_s, const Doubles &diameter_m,
                      const Doubles &density_kg_per_m3, const Ints &type, int first_id) {
  engine.create(checked(position_m, velocity_m_per_s, spin_rad_per_s, diameter_m, density_kg_per_m3, type),
                first_id);
}

void create_bodies(Engine &engine, const Doubles &position_m, const Doubles &velocity_m_per_s,
                  const Doubles &spin_rad_per_s, const Doubles &size_m, const Doubles &density_kg_per_m3,
                  const Ints &type, const Ints &shape, const Doubles &turn, int first_id) {
  check_shape("shape", shape, {position_m.shape(0)});
  check_shape("turn", turn, {position_m.shape(0), 4});
  engine.create_bodies(
      checked(position_m, velocity_m_per_s, spin_rad_per_s, size_m, density_kg_per_m3, type), shape.data(),
      turn.data(), first_id);
}

std::vector<bool> overlaps(Engine &engine, const Doubles &position_m, const Doubles &diameter_m) {
  check_shape("position_m", position_m, {kAny, 3});
  check_shape("diameter_m", diameter_m, {position_m.shape(0)});
  return engine.overlaps(position_m.data(), diameter_m.data(), static_cast<int>(diameter_m.size()));
}

void repeat_surface(Engine &engine, double period_m, const Ints &joined_triangles) {
  flipflow::FixSurface &surface = engine.surface();
  surface.repeat(period_m, corners_of("joined_triangles", joined_triangles, surface.vertices()));
}

void set_exits(Engine &engine, const Doubles &center_m, const Doubles &axes, const Doubles &half_m,
               const Doubles &domain_m, const Ints &below_deck, const Ints &deck) {
  check_shape("center_m", center_m, {kAny, 3});
  check_shape("axes", axes, {center_m.shape(0), 3, 3});
  check_shape("half_m", half_m, {center_m.shape(0), 3});
  check_shape("domain_m", domain_m, {2, 3});
  check_shape("below_deck", below_deck, {center_m.shape(0)});
  std::vector<flipflow::FixExits::Box> boxes(half_m.shape(0));
  for (size_t e = 0; e < boxes.size(); ++e) {
    boxes[e].center = flipflow::from(center_m.data() + 3 * e);
    for (int k = 0; k < 3; ++k) {
      boxes[e].axis[k] = flipflow::from(axes.data() + 9 * e + 3 * k);
      boxes[e].half[k] = half_m.at(e, k);
    }
    boxes[e].below_deck = below_deck.at(e) != 0;
  }
  engine.exits().set(std::move(boxes), flipflow::from(domain_m.data()),
                     flipflow::from(domain_m.data() + 3),
                     corners_of("deck", deck, engine.surface().points()), engine.surface().path(),
                     engine.surface().deck_contacts());
}

void set_deck(Engine &engine, const Doubles &along, const Doubles &across, const Ints &points,
              const Ints &panel, const Doubles &station_m, const Doubles &open_m, double reach_m,
              const Doubles &half_depth_m, const Ints &on_deck) {
  check_shape("along", along, {3});
  check_shape("across", across, {3});
  check_shape("points", points, {kAny});
  check_shape("panel", panel, {points.size()});
  check_shape("station_m", station_m, {points.size()});
  check_shape("open_m", open_m, {kAny, 4});
  check_shape("half_depth_m", half_depth_m, {open_m.shape(0)});
  flipflow::DeckLine line = {flipflow::from(along.data()), flipflow::from(across.data()), values_of(points),
                             values_of(panel), values_of(station_m), values_of(open_m), reach_m,
                             values_of(half_depth_m)};
  if (line.points.size() < 2) throw py::value_error("points: the line of a deck has two or more");
  for (const int point : line.points)
    if (point < 0 || point >= engine.surface().points())
      throw py::value_error("points: the deck names a point that is not there");
  for (const int number : line.panel)
    if (number < 0 || number >= line.panels())
      throw py::value_error("panel: the deck names a panel that is not there");
  engine.surface().set_deck(std::move(line), {on_deck.data(), on_deck.data() + on_deck.size()});
}

// One value, or three, of each row.
template <class Value, class Row, class Get>
py::array_t<Value> column(const std::vector<Row> &rows, Get get) {
  py::array_t<Value> array(static_cast<py::ssize_t>(rows.size()));
  for (size_t i = 0; i < rows.size(); ++i) array.mutable_at(i) = static_cast<Value>(get(rows[i]));
  return array;
}

// Of this rank: the particles that are here and those of them that are nowhere (a NaN or without bounds), then
// those that were removed and the crossings, until these are taken.
py::array_t<std::int64_t> tally(Engine &engine) {
  const LAMMPS_NS::Atom &atom = *engine.lammps().atom;
  std::int64_t nowhere = 0;
  for (int i = 0; i < atom.nlocal; ++i) {
    const double *const x = atom.x[i], *const v = atom.v[i];
    nowhere += !std::isfinite(x[0] + x[1] + x[2] + v[0] + v[1] + v[2]);
  }
  const int here = engine.bodies() ? engine.bodies()->count() : atom.nlocal;
  return array_of(std::vector<std::int64_t>{here, nowhere, engine.exits().removed(),
                                            engine.surface().crossings()}, {4});
}

template <class Row, class Get>
Doubles column3(const std::vector<Row> &rows, Get get) {
  Doubles array({static_cast<py::ssize_t>(rows.size()), py::ssize_t{3}});
  for (size_t i = 0; i < rows.size(); ++i) flipflow::put(array.mutable_data(i, 0), get(rows[i]));
  return array;
}

// What was counted of each particle (DeckContacts): the panel of its last contact, then a block of each panel's
// contacts, one of its seconds over each panel and one of those within reach.
Doubles deck_rows(const std::vector<flipflow::FixExits::Removed> &rows, int panels) {
  Doubles array({static_cast<py::ssize_t>(rows.size()), static_cast<py::ssize_t>(1 + 3 * panels)});
  for (size_t i = 0; i < rows.size(); ++i) {
    array.mutable_at(i, 0) = panels ? rows[i].deck[flipflow::DeckContacts::kLast] : -1.0;
    for (int k = 0; k < 3 * panels; ++k)
      array.mutable_at(i, 1 + k) = rows[i].deck[flipflow::DeckContacts::kFirst + k];
  }
  return array;
}

py::dict take_removed(Engine &engine) {
  using Row = flipflow::FixExits::Removed;
  const auto rows = engine.exits().take();
  const int panels = engine.surface().deck_contacts().panels();
  const auto before = engine.surface().first_step();
  const bool whole = engine.bodies();  // single spheres have no body
  py::dict arrays("x"_a = column3(rows, [](const Row &r) { return r.position_m; }),
                  "v"_a = column3(rows, [=](const Row &r) { return whole ? r.body.velocity : r.velocity_m_per_s; }),
                  "omega"_a = column3(rows, [](const Row &r) { return r.spin_rad_per_s; }),
                  "radius"_a = column<double>(rows, [](const Row &r) { return r.radius_m; }),
                  "rmass"_a = column<double>(rows, [](const Row &r) { return r.mass_kg; }),
                  "density"_a = column<double>(rows, [](const Row &r) { return r.density_kg_per_m3; }),
                  "type"_a = column<int>(rows, [](const Row &r) { return r.type; }),
                  "tag"_a = column<int>(rows, [=](const Row &r) { return whole ? r.body.id : r.tag; }),
                  "deck"_a = deck_rows(rows, panels),
                  "exit"_a = column<int>(rows, [](const Row &r) { return r.exit; }),
                  "velocity_behind"_a = column<double>(rows, [](const Row &r) { return r.velocity_behind; }),
                  "step"_a = column<int>(rows, [=](const Row &r) { return r.step - before; }));
  if (whole) {
    arrays["angular_momentum"] = column3(rows, [](const Row &r) { return r.body.momentum; });
    arrays["size"] = column<double>(rows, [](const Row &r) { return r.body.size_m; });
    arrays["shape"] = column<int>(rows, [](const Row &r) { return r.body.shape; });
  }
  return arrays;
}

py::dict take_crossings(Engine &engine) {
  using Row = flipflow::FixSurface::Crossing;
  const auto rows = engine.surface().take_crossings();
  const auto before = engine.surface().first_step();
  return py::dict("tag"_a = column<int>(rows, [](const Row &r) { return r.tag; }),
                  "step"_a = column<int>(rows, [=](const Row &r) { return r.step - before; }),
                  "x"_a = column3(rows, [](const Row &r) { return r.position_m; }));
}

void begin_path(Engine &engine, const Doubles &start_m, const Doubles &start_m_per_s,
                const Doubles &end_m, const Doubles &end_m_per_s, double length_s, int steps) {
  flipflow::FixSurface &surface = engine.surface();
  const py::ssize_t points = surface.points();
  check_shape("start_m", start_m, {points, 3});
  check_shape("start_m_per_s", start_m_per_s, {points, 3});
  check_shape("end_m", end_m, {points, 3});
  check_shape("end_m_per_s", end_m_per_s, {points, 3});
  surface.begin_path(start_m.data(), start_m_per_s.data(), end_m.data(), end_m_per_s.data(), length_s,
                     steps);
}

void run(Engine &engine, int steps, double step_s) {
  flipflow::FixAir *air = engine.air();
  engine.set_step(step_s);  // before the sums begin, which may evaluate contacts
  engine.surface().begin_sums(step_s);
  if (air) air->begin_sums(step_s);
  engine.run(steps);
  engine.surface().end_sums(step_s);
  if (air) air->end_sums(step_s);
}

// A table (types, types), row by row.
std::vector<double> table(const char *name, const Doubles &values, int types) {
  check_shape(name, values, {types, types});
  return values_of(values);
}

void set_laws(Engine &engine, const Doubles &e_star_Pa, const Doubles &g_star_Pa,
              bool tangential_spring, const Doubles &work_J_per_m2,
              const Doubles &energy_density_J_per_m3) {
  using Adhesion = flipflow::ContactLaws::Adhesion;
  flipflow::ContactLaws laws;
  laws.types = engine.lammps().atom->ntypes;
  laws.e_star_Pa = table("e_star_Pa", e_star_Pa, laws.types);
  laws.g_star_Pa = table("g_star_Pa", g_star_Pa, laws.types);
  laws.tangential_spring = tangential_spring;
  if (work_J_per_m2.size()) {
    laws.adhesion = Adhesion::jkr;
    laws.strength = table("work_J_per_m2", work_J_per_m2, laws.types);
  } else if (energy_density_J_per_m3.size()) {
    laws.adhesion = Adhesion::sjkr;
    laws.strength = table("energy_density_J_per_m3", energy_density_J_per_m3, laws.types);
  }
  engine.set_laws(laws);
}

// Before the input names a contact model.
void set_rebound(Engine &engine, int type, int other_type, const Doubles &speed_m_per_s,
                 const Doubles &restitution) {
  check_shape("restitution", restitution, {speed_m_per_s.size()});
  const flipflow::Rebound rebound = {values_of(speed_m_per_s), values_of(restitution)};
  auto &rebounds = flipflow::rebounds_of[&engine.lammps()];
  rebounds[{type, other_type}] = rebounds[{other_type, type}] = rebound;
}

void set_wear(Engine &engine, const Doubles &rate_m3_per_N_m) {
  const flipflow::ContactLaws &laws = engine.laws();
  flipflow::FixSurface &surface = engine.surface();
  surface.set_wear({table("rate_m3_per_N_m", rate_m3_per_N_m, laws.types), laws.types, laws.spring(),
                    surface.vertices()});
}

// What the air gave this rank's particles since t = 0; the input has `fix air`.
py::dict air(Engine &engine) {
  const flipflow::FixAir &air = *engine.air();
  return py::dict("impulse_N_s"_a = triple(air.impulse_N_s()),
                  "angular_impulse_N_m_s"_a = triple(air.angular_impulse_N_m_s()),
                  "work_J"_a = air.work_J());
}

py::dict by_name(flipflow::ContactEnergy energy) {
  return py::dict("elastic_J"_a = energy.elastic_J, "adhesion_J"_a = energy.adhesion_J);
}

// Of all steps since this was last asked, on this rank: the deepest overlap and the largest share of
// a diameter, between particles and with the surface.
py::dict take_deepest_overlaps(Engine &engine) {
  const auto between = std::exchange(flipflow::deepest_between[&engine.lammps()], {});
  const auto surface = engine.surface().take_deepest();
  return py::dict("between_m"_a = between.depth_m, "between_per_diameter"_a = between.share,
                  "surface_m"_a = surface.depth_m, "surface_per_diameter"_a = surface.share);
}

py::dict contact_tangent(Engine &engine, double length_s) {
  const py::ssize_t points = engine.surface().points();
  std::vector<double> push_N(3 * points, 0.0), impedance_N_s_per_m(9 * points, 0.0);
  engine.surface().tangent().predict(*engine.lammps().atom, length_s, push_N, impedance_N_s_per_m);
  return py::dict("push_N"_a = by_point(push_N),
                  "impedance_N_s_per_m"_a = array_of(impedance_N_s_per_m, {points, 3, 3}));
}

// The saved state as arrays by name, (n,) of float64 or int64, and back.
py::dict save(Engine &engine) {
  const flipflow::SavedState saved = engine.save();
  py::dict arrays;
  const auto add = [&](const auto &every) {
    for (const auto &[name, values] : every)
      arrays[py::str(name)] = array_of(values, {static_cast<py::ssize_t>(values.size())});
  };
  add(saved.reals);
  add(saved.wholes);
  return arrays;
}

void restore(Engine &engine, const py::dict &arrays) {
  flipflow::SavedState saved;
  for (const auto &[key, value] : arrays) {
    const auto name = key.cast<std::string>();
    const auto array = value.cast<py::array>();
    if (array.dtype().kind() == 'f')
      saved.reals[name] = values_of<double>(array);
    else
      saved.wholes[name] = values_of<std::int64_t>(array);
  }
  engine.restore(saved);
}

// An argument that is never converted: an array of another kind of number is refused.
py::arg exactly(const char *name) {
  py::arg argument(name);
  argument.noconvert();
  return argument;
}

}  // namespace

PYBIND11_MODULE(_liggghts, module) {
  const py::kw_only by_keyword;
  py::class_<Engine>(module, "Engine")
      .def(py::init([](int communicator, const std::string &screen, const std::string &log,
                       double contact_distance_factor, double class_ratio, bool as_packaged) {
             return std::make_unique<Engine>(MPI_Comm_f2c(communicator), screen, log,
                                             contact_distance_factor, class_ratio, as_packaged);
           }),
           by_keyword, py::arg("communicator"), py::arg("screen_file"), py::arg("log_file"),
           py::arg("contact_distance_factor"), py::arg("class_ratio"), py::arg("as_packaged") = false)
      .def("command", &Engine::command, py::arg("line"))
      .def("set_surface", &set_surface, by_keyword, exactly("position_m"), exactly("rigid_first"),
           exactly("rigid_share"), exactly("triangles"), exactly("type"), py::arg("largest_radius_m"))
      .def("set_laws", &set_laws, by_keyword, exactly("e_star_Pa"), exactly("g_star_Pa"),
           py::arg("tangential_spring"), exactly("work_J_per_m2"), exactly("energy_density_J_per_m3"))
      .def("set_rebound", &set_rebound, by_keyword, py::arg("type"), py::arg("other_type"),
           exactly("speed_m_per_s"), exactly("restitution"))
      .def("set_wear", &set_wear, exactly("rate_m3_per_N_m"))
      .def("create", &create_particles, by_keyword, exactly("position_m"), exactly("velocity_m_per_s"),
           exactly("spin_rad_per_s"), exactly("diameter_m"), exactly("density_kg_per_m3"),
           exactly("type"), py::arg("first_id"))
      .def("set_shapes", &set_shapes, by_keyword, exactly("count"), exactly("spheres"), exactly("volume"),
           exactly("inertia"), exactly("bounding_radius"), py::arg("reach_m"))
      .def("create_bodies", &create_bodies, by_keyword, exactly("position_m"), exactly("velocity_m_per_s"),
           exactly("spin_rad_per_s"), exactly("size_m"), exactly("density_kg_per_m3"), exactly("type"),
           exactly("shape"), exactly("turn"), py::arg("first_id"))
      .def("bodies", &bodies)
      .def("repeat_surface", &repeat_surface, by_keyword, py::arg("period_m"),
           exactly("joined_triangles"))
      .def("set_exits", &set_exits, by_keyword, exactly("center_m"), exactly("axes"),
           exactly("half_m"), exactly("domain_m"), exactly("below_deck"), exactly("deck"))
      .def("set_deck", &set_deck, by_keyword, exactly("along"), exactly("across"), exactly("points"),
           exactly("panel"), exactly("station_m"), exactly("open_m"), py::arg("reach_m"),
           exactly("half_depth_m"), exactly("on_deck"))
      .def("tally", &tally)
      .def("take_removed", &take_removed)
      .def("overlaps", &overlaps, by_keyword, exactly("position_m"), exactly("diameter_m"))
      .def("store_history", &Engine::store_history)
      .def("prepare", &Engine::prepare)
      .def("cuts", &Engine::cuts)
      .def("cut", &Engine::cut, py::arg("cuts"))
      .def("cut_later", &Engine::cut_later, py::arg("cuts"))
      .def("box_m",
           [](const Engine &e) {
             const std::array<double, 6> corners = e.box_m();
             return array_of(std::vector<double>(corners.begin(), corners.end()), {2, 3});
           })
      .def("begin_path", &begin_path, by_keyword, exactly("start_m"), exactly("start_m_per_s"),
           exactly("end_m"), exactly("end_m_per_s"), py::arg("length_s"), py::arg("steps"))
      .def("run", &run, by_keyword, py::arg("steps"), py::arg("step_s"))
      .def("save", &save)
      .def("restore", &restore, py::arg("arrays"))
      .def("particles", &particles)
      .def("impulse_N_s", [](Engine &e) { return by_point(e.surface().load().impulse_N_s()); })
      .def("force_N", [](Engine &e) { return by_point(e.surface().load().force_N()); })
      .def("ask_contact_tangent", [](Engine &e) { e.surface().tangent().ask(); })
      .def("contact_tangent", &contact_tangent, py::arg("length_s"))
      .def("worn_m3",
           [](Engine &e) {
             const std::vector<double> &worn = e.surface().wear().worn_m3();
             return array_of(worn, {static_cast<py::ssize_t>(worn.size())});
           })
      .def("angular_impulse_N_m_s",
           [](Engine &e) { return triple(e.surface().load().angular_impulse_N_m_s()); })
      .def("mass_moment_time_kg_m_s",
           [](Engine &e) { return triple(e.surface().mass_moment_time()); })
      .def("surface_work_J", [](Engine &e) { return e.surface().load().work_J(); })
      .def("air", &air)
      .def("surface_energy_J", [](Engine &e) { return by_name(e.surface().energy()); })
      .def("take_deepest_overlaps", &take_deepest_overlaps)
      .def("take_crossings", &take_crossings)
      .def("contact_numbers",
           [](Engine &e) {
             const auto numbers = e.bodies() ? flipflow::contact_numbers(e.lammps(), e.laws(), *e.bodies())
                                             : flipflow::contact_numbers(e.lammps(), e.laws());
             return array_of(numbers, {static_cast<py::ssize_t>(numbers.size())});
           })
      .def("pair_energy_J",
           [](Engine &e) { return by_name(flipflow::pair_energy(e.lammps(), e.laws())); });
}
