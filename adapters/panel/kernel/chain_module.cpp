#include "bound.h"
#include "chain.h"
#include "modules.h"

namespace flipflow {

ChainState state_of(const Chain &chain, std::vector<Doubles> &arrays) {
  const py::ssize_t size = chain.size(), branches = chain.branches();
  const auto at = [&](size_t k, py::ssize_t wanted, const char *name) {
    return into(arrays.at(k), wanted, name);
  };
  return {at(0, size, "position_m"),
          at(1, size, "velocity_m_per_s"),
          at(2, size, "internal_N"),
          at(3, chain.strains(), "strain"),
          at(4, chain.strains() * branches, "stress"),
          at(5, branches, "energy_J"),
          at(6, 1, "lost_J")};
}

namespace {

using BoundChain = Bound<Chain, ChainState>;

Chain chain(int first, double rest_m, double c10_Pa, double c01_Pa, const Doubles &area_m2,
            const Doubles &bending_N_m3, const Doubles &curvature_1_m2, const Ints &at_clamp,
            const Doubles &along, const Doubles &mass_kg, const Ints &held, const Ints &free,
            const Doubles &across, const Doubles &share, const Doubles &ratio,
            const Doubles &time_s) {
  of(curvature_1_m2, 3 * bending_N_m3.size(), "curvature_1_m2");
  of(along, 3, "along");
  of(across, 3, "across");
  of(share, mass_kg.size() * held.size(), "share");
  of(time_s, ratio.size(), "time_s");
  if (at_clamp.size() != bending_N_m3.size() || mass_kg.size() != bending_N_m3.size() + 2 ||
      first + area_m2.size() >= mass_kg.size())
    throw py::value_error("springs, bends and rows do not fit together");
  const ChainLinks links = {first, rest_m, c10_Pa, c01_Pa, copied(area_m2), copied(bending_N_m3),
                            copied(curvature_1_m2), copied(at_clamp), copied(along)};
  const ChainRows rows = {copied(mass_kg), copied(held), copied(free), copied(across),
                          copied(share)};
  return Chain(ChainForce(links), rows, Branches(copied(ratio), copied(time_s)));
}

}  // namespace

void add_chain(py::module_ &module) {
  py::class_<BoundChain> bound(module, "Chain");
  bound.def(py::init([](int first, double rest_m, double c10_Pa, double c01_Pa,
                       const Doubles &area_m2, const Doubles &bending_N_m3,
                       const Doubles &curvature_1_m2, const Ints &at_clamp, const Doubles &along,
                       const Doubles &mass_kg, const Ints &held, const Ints &free,
                       const Doubles &across, const Doubles &share, const Doubles &ratio,
                       const Doubles &time_s, std::vector<Doubles> state) {
             return BoundChain(chain(first, rest_m, c10_Pa, c01_Pa, area_m2, bending_N_m3,
                                     curvature_1_m2, at_clamp, along, mass_kg, held, free, across,
                                     share, ratio, time_s),
                               std::move(state));
           }),
           py::kw_only(), py::arg("first"), py::arg("rest_m"), py::arg("c10_Pa"),
           py::arg("c01_Pa"), py::arg("area_m2"), py::arg("bending_N_m3"),
           py::arg("curvature_1_m2"), py::arg("at_clamp"), py::arg("along"), py::arg("mass_kg"),
           py::arg("held"), py::arg("free"), py::arg("across"), py::arg("share"),
           py::arg("ratio"), py::arg("time_s"), py::arg("state").noconvert());
  add_motion(bound);
}

}  // namespace flipflow
