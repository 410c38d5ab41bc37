// ns of a call of Pinocchio's algorithms: cost CHAIN CALLS [QUESTION]. See README.md.
//
// CHAIN is what compare.py writes of a model. Pinocchio's dynamic model (joints known at run time), header only. As
// in robots/examples/dynamics_cost.rs: 256 random states in turn, of 20 batches the fastest, sine and cosine included.

#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

struct State {
    Eigen::VectorXd q, v, a;
};

static pinocchio::Model read(const char* path) {
    pinocchio::Model model;
    std::ifstream file(path);
    pinocchio::JointIndex parent = 0;
    for (std::string line; std::getline(file, line);) {
        std::istringstream fields(line);
        char kind = 0;
        double mass = 0.0;
        Eigen::Matrix3d rotation, inertia;
        Eigen::Vector3d position, centre;
        fields >> kind;
        for (int i = 0; i < 9; ++i) fields >> rotation(i / 3, i % 3);
        for (int i = 0; i < 3; ++i) fields >> position(i);
        fields >> mass;
        for (int i = 0; i < 3; ++i) fields >> centre(i);
        for (int i = 0; i < 9; ++i) fields >> inertia(i / 3, i % 3);
        if (!fields) std::exit(3);
        const pinocchio::SE3 placement(rotation, position);
        const std::string name = "joint" + std::to_string(parent);
        parent = kind == 'P' ? model.addJoint(parent, pinocchio::JointModelPZ(), placement, name)
                             : model.addJoint(parent, pinocchio::JointModelRZ(), placement, name);
        model.appendBodyToJoint(parent, pinocchio::Inertia(mass, centre, inertia));
    }
    return model;
}

int main(int argc, char** argv) {
    if (argc < 3) return 2;
    const pinocchio::Model model = read(argv[1]);
    pinocchio::Data data(model);
    const int calls = std::atoi(argv[2]);
    const char* only = argc > 3 ? argv[3] : nullptr;
    std::srand(1);
    std::vector<State> states;
    for (int i = 0; i < 256; ++i) {
        states.push_back({3.0 * Eigen::VectorXd::Random(model.nq), 2.0 * Eigen::VectorXd::Random(model.nv),
                          5.0 * Eigen::VectorXd::Random(model.nv)});
    }
    volatile double sink = 0.0;
    const std::pair<const char*, std::function<void(const State&)>> questions[] = {
        {"fk",
         [&](const State& s) {
             pinocchio::forwardKinematics(model, data, s.q);
             sink = data.oMi.back().translation().x();
         }},
        {"rnea", [&](const State& s) { sink = pinocchio::rnea(model, data, s.q, s.v, s.a).sum(); }},
        {"crba", [&](const State& s) { sink = pinocchio::crba(model, data, s.q, pinocchio::Convention::LOCAL).sum(); }},
        {"forward",
         [&](const State& s) { sink = pinocchio::aba(model, data, s.q, s.v, s.a, pinocchio::Convention::WORLD).sum(); }},
    };
    for (const auto& [name, ask] : questions) {
        if (only && std::strcmp(only, name) != 0) continue;
        const int batch = calls / 20 > 0 ? calls / 20 : 1;
        double best = 1e300;
        for (int done = 0; done < calls; done += batch) {
            const auto since = std::chrono::steady_clock::now();
            for (int i = 0; i < batch; ++i) ask(states[i % 256]);
            const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - since;
            if (took.count() / batch < best) best = took.count() / batch;
        }
        std::printf("%s %.1f\n", name, best);
    }
}
