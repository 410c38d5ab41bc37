// Plans with Ruckig, and times it: no call from Rust happens inside a timed loop.

#include <ruckig/ruckig.hpp>

#include <chrono>
#include <cstddef>
#include <memory>
#include <vector>

namespace {

// As `Axis` in case.rs.
struct Axis {
    double p0, v0, a0, p1, v1, a1, v_min, v_max, a_min, a_max, j_max;
};

// As `Phase` in plan.rs.
struct Phase {
    double t, j, a0, v0, p0;
};

// Two of the brake, seven of the profile.
constexpr std::size_t MAX_PHASES = 9;

// As `RawPlan` in ruckig.rs: the phases of one axis.
struct AxisPhases {
    std::size_t count;
    Phase phases[MAX_PHASES];
};

class Batch {
public:
    virtual ~Batch() = default;
    virtual int plan(std::size_t index, double* duration, AxisPhases* axes) = 0;
    virtual double run() = 0;
    virtual void calls(double* least_ns) = 0;
    virtual void keep() = 0;
    virtual double sample(std::size_t samples) const = 0;
};

AxisPhases phases_of(const ruckig::Profile& profile) {
    AxisPhases axis {};
    const auto& brake = profile.brake;
    if (brake.duration > 0) {
        const std::size_t parts = brake.t[1] > 0 ? 2 : 1;
        for (std::size_t i = 0; i < parts; ++i) {
            axis.phases[axis.count++] = {brake.t[i], brake.j[i], brake.a[i], brake.v[i], brake.p[i]};
        }
    }
    for (std::size_t i = 0; i < 7; ++i) {
        axis.phases[axis.count++] = {profile.t[i], profile.j[i], profile.a[i], profile.v[i], profile.p[i]};
    }
    return axis;
}

template<std::size_t N>
ruckig::InputParameter<N> input_of(const Axis* axes) {
    ruckig::InputParameter<N> input;
    bool symmetric = true;
    std::array<double, N> v_min, a_min;
    for (std::size_t i = 0; i < N; ++i) {
        const Axis& axis = axes[i];
        input.current_position[i] = axis.p0;
        input.current_velocity[i] = axis.v0;
        input.current_acceleration[i] = axis.a0;
        input.target_position[i] = axis.p1;
        input.target_velocity[i] = axis.v1;
        input.target_acceleration[i] = axis.a1;
        input.max_velocity[i] = axis.v_max;
        input.max_acceleration[i] = axis.a_max;
        input.max_jerk[i] = axis.j_max;
        v_min[i] = axis.v_min;
        a_min[i] = axis.a_min;
        symmetric = symmetric && axis.v_min == -axis.v_max && axis.a_min == -axis.a_max;
    }
    if (!symmetric) {
        input.min_velocity = v_min;
        input.min_acceleration = a_min;
    }
    return input;
}

template<std::size_t N>
class BatchOf : public Batch {
    ruckig::Ruckig<N> planner;
    ruckig::Trajectory<N> trajectory;
    std::vector<ruckig::InputParameter<N>> inputs;
    std::vector<ruckig::Trajectory<N>> kept;

public:
    BatchOf(const Axis* axes, std::size_t count) {
        inputs.reserve(count);
        for (std::size_t i = 0; i < count; ++i) {
            inputs.push_back(input_of<N>(axes + i * N));
        }
    }

    int plan(std::size_t index, double* duration, AxisPhases* axes) override {
        const int result = planner.calculate(inputs[index], trajectory);
        if (result < 0) {
            return result;
        }
        *duration = trajectory.get_duration();
        const auto profiles = trajectory.get_profiles();
        for (std::size_t i = 0; i < N; ++i) {
            axes[i] = phases_of(profiles[0][i]);
        }
        return result;
    }

    // The name is what callgrind looks for.
    __attribute__((noinline)) double measured_work() {
        double sum = 0.0;
        for (const auto& input : inputs) {
            planner.calculate(input, trajectory);
            sum += trajectory.get_duration();
        }
        return sum;
    }

    double run() override {
        return measured_work();
    }

    void calls(double* least_ns) override {
        for (std::size_t i = 0; i < inputs.size(); ++i) {
            const auto began = std::chrono::steady_clock::now();
            planner.calculate(inputs[i], trajectory);
            const auto ended = std::chrono::steady_clock::now();
            const double ns = std::chrono::duration<double, std::nano>(ended - began).count();
            if (ns < least_ns[i]) {
                least_ns[i] = ns;
            }
        }
    }

    void keep() override {
        kept.clear();
        for (const auto& input : inputs) {
            planner.calculate(input, trajectory);
            kept.push_back(trajectory);
        }
    }

    double sample(std::size_t samples) const override {
        std::array<double, N> p, v, a, j;
        std::size_t section;
        double sum = 0.0;
        for (const auto& plan : kept) {
            const double step = plan.get_duration() / static_cast<double>(samples);
            for (std::size_t i = 0; i < samples; ++i) {
                plan.at_time(static_cast<double>(i) * step, p, v, a, j, section);
                for (std::size_t axis = 0; axis < N; ++axis) {
                    sum += p[axis] + v[axis] + a[axis] + j[axis];
                }
            }
        }
        return sum;
    }
};

} // namespace

extern "C" {

Batch* ruckig_batch(std::size_t axes, const Axis* cases, std::size_t count) noexcept {
    switch (axes) {
        case 1: return new BatchOf<1>(cases, count);
        case 2: return new BatchOf<2>(cases, count);
        case 3: return new BatchOf<3>(cases, count);
        case 6: return new BatchOf<6>(cases, count);
        case 7: return new BatchOf<7>(cases, count);
        default: return nullptr;
    }
}

void ruckig_free(Batch* batch) noexcept {
    delete batch;
}

int ruckig_plan(Batch* batch, std::size_t index, double* duration, AxisPhases* axes) noexcept {
    return batch->plan(index, duration, axes);
}

double ruckig_run(Batch* batch) noexcept {
    return batch->run();
}

void ruckig_calls(Batch* batch, double* least_ns) noexcept {
    batch->calls(least_ns);
}

void ruckig_keep(Batch* batch) noexcept {
    batch->keep();
}

double ruckig_sample(const Batch* batch, std::size_t samples) noexcept {
    return batch->sample(samples);
}

} // extern "C"
