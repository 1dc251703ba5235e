// C that CasADi writes for Pinocchio's algorithms of one robot; build.py compiles this program.
// Usage: generate MODEL.txt TASK FOLDER; writes FOLDER/TASK.c with the function f(q, v, x), x being efforts for
// aba and accelerations for rnea, and prints its number of instructions. Equal expressions are merged (cse). Of the
// two conventions of aba and crba the one with fewer instructions counts.
#include <cstdio>
#include <cstring>
#include <string>

#include "pinocchio/autodiff/casadi.hpp"

#include "pinocchio/multibody.hpp"
#include "pinocchio/algorithm/aba-derivatives.hpp"
#include "pinocchio/algorithm/aba.hpp"
#include "pinocchio/algorithm/crba.hpp"
#include "pinocchio/algorithm/rnea.hpp"
#include "pinocchio/serialization.hpp"

using SX = casadi::SX;
using Vector = Eigen::Matrix<SX, Eigen::Dynamic, 1>;
using pinocchio::Convention;

static Vector entries(const SX &x) {
    Vector found(x.numel());
    for (casadi_int k = 0; k < x.numel(); ++k) found[k] = x(k);
    return found;
}

template <class M>
static SX symbolic(const M &a) {
    SX found(a.rows(), a.cols());
    for (Eigen::Index i = 0; i < a.rows(); ++i)
        for (Eigen::Index j = 0; j < a.cols(); ++j) found(i, j) = a(i, j);
    return found;
}

int main(int argc, char **argv) {
    if (argc != 4) return 2;
    pinocchio::Model numbers;
    numbers.loadFromText(argv[1]);
    const std::string task = argv[2], folder = argv[3];
    const auto model = numbers.cast<SX>();
    const SX q = SX::sym("q", model.nq), v = SX::sym("v", model.nv), x = SX::sym("x", model.nv);
    const Vector qs = entries(q), vs = entries(v), xs = entries(x);
    casadi::Function best;
    for (const Convention convention : {Convention::WORLD, Convention::LOCAL}) {
        pinocchio::DataTpl<SX> data(model);
        std::vector<SX> outputs;
        if (task == "forward_dynamics") {
            outputs = {symbolic(pinocchio::aba(model, data, qs, vs, xs, convention))};
        } else if (task == "inverse_dynamics") {
            outputs = {symbolic(pinocchio::rnea(model, data, qs, vs, xs))};
        } else if (task == "mass_matrix") {
            data.M.setZero();
            outputs = {symbolic(pinocchio::crba(model, data, qs, convention))};
        } else if (task == "derivatives") {
            data.Minv.setZero();
            pinocchio::computeABADerivatives(model, data, qs, vs, xs);
            outputs = {symbolic(data.ddq), symbolic(data.ddq_dq), symbolic(data.ddq_dv), symbolic(data.Minv)};
        } else {
            return 3;
        }
        casadi::Function f("f", {q, v, x}, cse(outputs));
        if (best.is_null() || f.n_instructions() < best.n_instructions()) best = f;
    }
    casadi::CodeGenerator generator(task);
    generator.add(best);
    generator.generate(folder + "/");
    std::printf("%lld\n", static_cast<long long>(best.n_instructions()));
    return 0;
}
