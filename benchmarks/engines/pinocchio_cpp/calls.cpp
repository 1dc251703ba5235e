// Times of Pinocchio's recursions, one call after another over the same states; build.py compiles it.
// Usage: calls MODEL.txt STATES.bin REPEATS RESULTS.bin
// STATES.bin: count, n_q, n_v as doubles, then q, v, tau of each state. RESULTS.bin: for each state the accelerations
// of aba and the torques of rnea at a = tau, as a check. Prints "name nanoseconds", one line for every repetition, in
// the processor time of this process, so that what else runs on the machine does not count.
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <vector>

#include "pinocchio/multibody.hpp"
#include "pinocchio/algorithm/aba-derivatives.hpp"
#include "pinocchio/algorithm/aba.hpp"
#include "pinocchio/algorithm/crba.hpp"
#include "pinocchio/algorithm/rnea.hpp"
#include "pinocchio/serialization.hpp"

using Vectors = std::vector<Eigen::VectorXd, Eigen::aligned_allocator<Eigen::VectorXd>>;

static volatile double sink;

static double now() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e9 * double(t.tv_sec) + double(t.tv_nsec);
}

template <class Call>
static void timed(const char *name, size_t count, long repeats, Call call) {
    for (long k = 0; k < repeats; ++k) {
        const double start = now();
        double sum = 0;
        for (size_t i = 0; i < count; ++i) sum += call(i);
        const double took = now() - start;
        sink = sum;
        std::printf("%s %.3f\n", name, took / double(count));
    }
}

int main(int argc, char **argv) {
    if (argc != 5) return 2;
    pinocchio::Model model;
    model.loadFromText(argv[1]);
    pinocchio::Data data(model);

    std::ifstream file(argv[2], std::ios::binary);
    double head[3];
    file.read(reinterpret_cast<char *>(head), sizeof head);
    const auto count = static_cast<size_t>(head[0]);
    if (int(head[1]) != model.nq || int(head[2]) != model.nv) return 3;
    Vectors q, v, tau;
    for (size_t i = 0; i < count; ++i) {
        Eigen::VectorXd a(model.nq), b(model.nv), c(model.nv);
        file.read(reinterpret_cast<char *>(a.data()), sizeof(double) * model.nq);
        file.read(reinterpret_cast<char *>(b.data()), sizeof(double) * model.nv);
        file.read(reinterpret_cast<char *>(c.data()), sizeof(double) * model.nv);
        q.push_back(a), v.push_back(b), tau.push_back(c);
    }
    if (!file) return 4;
    const long repeats = std::atol(argv[3]);
    using pinocchio::Convention;
    timed("aba_world", count, repeats, [&](size_t i) {
        return pinocchio::aba(model, data, q[i], v[i], tau[i], Convention::WORLD)[0];
    });
    timed("aba_local", count, repeats, [&](size_t i) {
        return pinocchio::aba(model, data, q[i], v[i], tau[i], Convention::LOCAL)[0];
    });
    timed("crba_world", count, repeats, [&](size_t i) {
        return pinocchio::crba(model, data, q[i], Convention::WORLD)(0, 0);
    });
    timed("crba_local", count, repeats, [&](size_t i) {
        return pinocchio::crba(model, data, q[i], Convention::LOCAL)(0, 0);
    });
    timed("rnea", count, repeats, [&](size_t i) { return pinocchio::rnea(model, data, q[i], v[i], tau[i])[0]; });
    timed("derivatives", count, repeats, [&](size_t i) {
        pinocchio::computeABADerivatives(model, data, q[i], v[i], tau[i]);
        return data.ddq_dq(0, 0);
    });
    std::ofstream out(argv[4], std::ios::binary);
    for (size_t i = 0; i < count; ++i) {
        const Eigen::VectorXd a = pinocchio::aba(model, data, q[i], v[i], tau[i], Convention::WORLD);
        const Eigen::VectorXd f = pinocchio::rnea(model, data, q[i], v[i], tau[i]);
        out.write(reinterpret_cast<const char *>(a.data()), sizeof(double) * model.nv);
        out.write(reinterpret_cast<const char *>(f.data()), sizeof(double) * model.nv);
    }
    return 0;
}
