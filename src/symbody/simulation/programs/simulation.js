// One motion that goes on as far as it is asked to, with inputs, parameters and first values that change.
// What it calls, `symbody_*`, are the kernels; `functions` are those of the mechanism, `numbers` its data.
function makeSimulation() {
    const { at, codes, view } = numbers;
    const n = numbers.block[at.run.states], speeds = numbers.block[at.run.speeds];
    const block = Float64Array.from(numbers.block);
    const isProjected = block[at.run.projection] !== 0;
    const rows = block[at.run["method.dense_rows"]], room = block[at.run["room.steps"]];
    const nothing = new Float64Array(1);
    // The steps that are at hand: when each ends, and its dense output.
    const breaks = new Float64Array(room + 2), pieces = new Float64Array((room + 1) * rows * n);
    // What kernels take; the rest is null where nothing of its kind happens on the way.
    const copyOf = (array) => (array === null ? null : Float64Array.from(array));
    const m = { block, breaks, pieces, times: nothing, t: nothing, x: nothing };
    for (const name of ["monitor", "held", "sampling", "jumps", "modes", "implicit"]) m[name] = copyOf(numbers[name]);
    const { monitor, held, jumps, modes } = m;
    const elements = modes === null ? 0 : modes[at.modes.count];
    if (modes !== null) m.decided = new Float64Array(modes[at.modes.room] * (3 + elements + n));
    const width = held === null ? 0 : held[at.held.count] + 1;
    m.recorded = held === null ? null : new Float64Array(held[at.held.room] * width);
    const parameters = Float64Array.from(numbers.parameters.values);
    const inputs = new Float64Array(numbers.inputs.names.length);
    // Nothing sticks and no gap is closed where states are closed; kernels show the modes of the motion.
    if (modes !== null) inputs.fill(1, modes[at.modes.first_input]);
    const state = Float64Array.from(numbers.start), first = Float64Array.from(numbers.start);
    const shown = new Float64Array(view.size);
    const pose = { positions: new Float64Array(3 * view.parents.length), axes: new Float64Array(9 * view.parents.length) };
    const assembly = numbers.assembly === null ? null : Float64Array.from(numbers.assembly);
    const seen = Float64Array.from(view.numbers);

    // Each function with the array in which its numbers lie, and where they begin.
    const calls = [{ values: functions.motionValues, array: block, place: block[at.run.numbers] }];
    calls.push({ values: functions.viewValues, array: seen, place: 0 });
    if (isProjected) {
        const place = block[at.run.projection] + block[block[at.run.projection] + at.projection.numbers];
        calls.push({ values: functions.projectionValues, array: block, place });
    }
    if (assembly !== null) {
        calls.push({ values: functions.assemblyValues, array: assembly, place: assembly[at.assembly.numbers] });
    }
    if (m.implicit !== null) {
        calls.push({ values: functions.turnValues, array: m.implicit, place: m.implicit[at.implicit.rate_numbers] });
        calls.push({ values: functions.derivativesValues, array: m.implicit, place: m.implicit[at.implicit.derivative_numbers] });
    }
    if (monitor !== null) {
        calls.push({ values: functions.eventsValues, array: monitor, place: monitor[at.monitor.numbers] });
        const acting = monitor[at.monitor.actions], closing = monitor[at.monitor.closing];
        if (acting !== 0) calls.push({ values: functions.actionsValues, array: monitor, place: acting });
        if (closing !== 0) calls.push({ values: functions.assemblyValues, array: monitor, place: closing + monitor[closing + at.assembly.numbers] });
    }
    if (held !== null) calls.push({ values: functions.samples === null ? functions.eventsValues : functions.samplesValues, array: m.sampling, place: 0 });
    if (modes !== null) {
        calls.push({ values: functions.decidingValues, array: modes, place: modes[at.modes.numbers] });
        calls.push({ values: functions.fittingValues, array: modes, place: modes[at.modes.projection] });
    }
    if (jumps !== null) {
        const problem = jumps[at.jumps.problem];
        calls.push({ values: functions.strikeValues, array: jumps, place: problem + jumps[problem + at.strike.numbers] });
    }

    let time = numbers.startTime;
    let code = codes.RUNNING;
    let isFresh = true; // the integrator has to begin at `state`
    let pull = null;

    // What follows changes the motion from the time shown on: forget what lies behind it, note where events stand.
    function interrupt() {
        if (isFresh) return;
        isFresh = true;
        for (let k = 0; monitor !== null && k < monitor[at.monitor.happened]; k += 1) {
            const t = m.happened[k * (n + 2) + 1];
            if (t > time && t - time <= instant(time)) { // of the time shown, up to rounding
                time = t;
                showState();
            }
        }
        block[at.run.time] = time;
        block.set(state, block[at.run.state_old]);
        kernels.rewindEvents?.(m, time);
        kernels.rewindSamples?.(m, time);
        kernels.rewindModes?.(m, time);
        if (held !== null) showHeld(held.subarray(held[at.held.values]));
        kernels.note?.(m);
    }

    // Let the inputs have held values.
    function showHeld(values) {
        for (let k = 0; k < width - 1; k += 1) inputs[held[held[at.held.slots] + k]] = values[k];
    }

    function writeArguments() {
        interrupt();
        for (const { values, array, place } of calls) {
            const p = place + array[place + at.numbers.parameters], c = place + array[place + at.numbers.constants];
            array.set(inputs, place + array[place + at.numbers.inputs]);
            array.set(parameters, p);
            if (values !== null) {
                const work = new Float64Array(values.work);
                values.call(nothing, 0, nothing, 0, nothing, 0, nothing, 0, array, p, array, c, array, c, work, 0);
            }
        }
    }

    function begin() {
        block[at.run.time] = time;
        block.set(state, block[at.run.state_old]);
        block[at.run["counts.failed_kernel"]] = block[at.run["counts.steps"]] = block[at.run["counts.samples"]] = 0;
        block[at.run.after_rejection] = block[at.run.stiff_votes] = block[at.run.other_votes] = block[at.run.unjudged] = 0;
        kernels.bound?.(m);
        code = kernels.begin(m);
        kernels.watch?.(m);
        isFresh = false;
        block[at.run.first_step] = numbers.isFixed ? block[at.run["goal.max_step"]] : Math.abs(block[at.run.step]);
    }

    function step() {
        const accepted = block[at.run["counts.accepted"]];
        if (block[at.run["counts.steps"]] === room) forget();
        code = kernels.advance(m);
        if (code === codes.FULL) code = codes.RUNNING;
        else if (code === codes.NO_EVENT_ROOM) makeRoom(2 * monitor[at.monitor.happened_room]);
        else if (code === codes.NO_SAMPLE_ROOM) forgetSamples();
        else if (code === codes.NO_MODE_ROOM) forgetModeRows();
        if (!numbers.isFixed && block[at.run["counts.accepted"]] !== accepted) block[at.run.first_step] = Math.abs(block[at.run.step]);
    }

    // Make room for steps: zeros of events lie in the last ones.
    function forget() {
        if (monitor !== null) kernels.forget(m);
        else {
            breaks[0] = breaks[1];
            block[at.run["counts.steps"]] = 0;
        }
    }

    function forgetSamples() {
        const kept = held[at.held.room] / 2;
        m.recorded.copyWithin(0, kept * width);
        held[at.held.recorded] = kept;
        code = codes.RUNNING;
    }

    function forgetModeRows() {
        kernels.forgetRows(m);
        code = codes.RUNNING;
    }

    function makeRoom(count) {
        const before = m.happened;
        m.happened = new Float64Array(count * (n + 2));
        if (before !== undefined) m.happened.set(before);
        monitor[at.monitor.happened_room] = count;
        code = codes.RUNNING;
    }

    // What counts as one time for events.
    function instant(t) {
        return monitor === null ? 0 : 2e-12 * Math.max(monitor[at.monitor.span], Math.abs(t));
    }

    // Up to when nothing that is still found changes the motion.
    function settled() {
        if (monitor === null || code !== codes.RUNNING) return block[at.run.time];
        return monitor[at.monitor.seen] === 0 ? breaks[monitor[at.monitor.first_step]] : monitor[at.monitor.t_before];
    }

    function showState() {
        let k = block[at.run["counts.steps"]] - 1;
        while (k > 0 && time < breaks[k]) k -= 1;
        if (k >= 0 && time < breaks[k + 1]) {
            const share = Math.max((time - breaks[k]) / (breaks[k + 1] - breaks[k]), 0);
            symbody_interpolate(n, rows, pieces, k * rows * n, share, state, 0);
            if (isProjected) projectShown();
        } else {
            state.set(block.subarray(block[at.run.state_old], block[at.run.state_old] + n));
        }
        if (held !== null) showHeldAt();
    }

    // Bring the state shown onto the constraints of the modes that it has.
    function projectShown() {
        const place = modes === null ? 0 : block[at.run.projection] + block[block[at.run.projection] + at.projection.numbers];
        if (modes !== null) showModesOf(time, block, place);
        symbody_project(functions.projection, block, 0, time, state, 0);
        if (modes !== null) showModesOf(Infinity, block, place);
    }

    // Let the numbers of a function have the modes of a time, as far as they are written down.
    function showModesOf(t, array, place) {
        const size = 3 + elements + n, isShock = (row) => m.decided[row * size] !== 0;
        let row = modes[at.modes.recorded] - 1;
        while (row > 0 && (m.decided[row * size + 1] > t || isShock(row))) row -= 1;
        if (row < 0) return;
        const first = place + array[place + at.numbers.inputs] + modes[at.modes.first_input];
        for (let k = 0; k < elements; k += 1) array[first + k] = m.decided[row * size + 3 + k];
    }

    // Let the view have the held values of the time shown.
    function showHeldAt() {
        let row = held[at.held.recorded] - 1;
        while (row > 0 && m.recorded[row * width] > time) row -= 1;
        if (row < 0) return;
        showHeld(m.recorded.subarray(row * width + 1));
        seen.set(inputs, seen[at.numbers.inputs]);
    }

    // Go on to a time [s] with at most so many trials of steps; return whether it was reached.
    function goTo(target, trials) {
        if (isFresh) begin();
        const end = Math.min(target, jumps === null ? block[at.run.t_end] : jumps[at.jumps.t_end]);
        let left = trials;
        while (code === codes.RUNNING && settled() < end + instant(end) && left > 0) {
            step();
            left -= 1;
        }
        const reached = settled() >= end;
        time = reached ? end : settled();
        showState();
        return reached;
    }

    // The same with a body pulled: the wrench is renewed often, since the pointer is a spring of its own.
    function advanceTo(target, trials = Infinity) {
        if (pull === null) return goTo(target, trials);
        const parts = Math.max(1, Math.ceil((target - time) / numbers.pull.interval));
        const start = time;
        for (let k = 1; k <= parts; k += 1) {
            const goal = start + ((target - start) * k) / parts;
            applyPull(goal - time);
            if (!goTo(goal, trials)) return false;
        }
        return true;
    }

    function evaluateView(x) {
        if (modes !== null) showModesOf(time, seen, 0);
        symbody_call(functions.view, speeds, seen, 0, time, x, 0, shown, 0);
    }

    // Poses of all bodies for a state: each from the one that it is placed from.
    function computePose(x) {
        evaluateView(x);
        const { parents, order } = view;
        const { positions, axes } = pose;
        for (const k of order) {
            const parent = parents[k], r = 3 * k, R = 3 * parents.length + 9 * k;
            for (let i = 0; i < 3; i += 1) {
                let place = parent < 0 ? 0 : positions[3 * parent + i];
                for (let j = 0; j < 3; j += 1) {
                    place += axisEntry(parent, i, j) * shown[r + j];
                    let entry = 0;
                    for (let m = 0; m < 3; m += 1) entry += axisEntry(parent, i, m) * shown[R + 3 * m + j];
                    axes[9 * k + 3 * i + j] = entry;
                }
                positions[3 * k + i] = place;
            }
        }
        return pose;
    }

    function axisEntry(body, i, j) {
        return body < 0 ? (i === j ? 1 : 0) : pose.axes[9 * body + 3 * i + j];
    }

    // Where a point of a body, in its axes, is in ground's axes; of the pose computed last.
    function placeOf(body, point) {
        return [0, 1, 2].map((i) => {
            let place = pose.positions[3 * body + i];
            for (let j = 0; j < 3; j += 1) place += pose.axes[9 * body + 3 * i + j] * point[j];
            return place;
        });
    }

    function writeWrench(force, arm) {
        interrupt();
        const { wrench, weights } = numbers.pull;
        const torque = [0, 1, 2].map((i) => arm[(i + 1) % 3] * force[(i + 2) % 3] - arm[(i + 2) % 3] * force[(i + 1) % 3]);
        wrench.forEach((place, i) => { inputs[place] = i < 3 ? force[i] : torque[i - 3]; });
        weights.forEach((place, body) => { inputs[place] = pull !== null && body === pull.body ? 1 : 0; });
        for (const { array, place } of calls) array.set(inputs, place + array[place + at.numbers.inputs]);
    }

    // The mass that a point of a body has in a direction: what the constraints and the other bodies make of it.
    function massAt(point, direction) {
        const slopes = [0, 1].map((size) => {
            const centre = [0, 1, 2].map((i) => pose.positions[3 * pull.body + i]);
            writeWrench(direction.map((each) => each * size), point.map((each, i) => each - centre[i]));
            const slope = new Float64Array(n);
            symbody_call(functions.motion, speeds, block, block[at.run.numbers], time, state, 0, slope, 0);
            return slope;
        });
        const small = 1e-6 / Math.max(1e-300, ...Array.from(slopes[1].subarray(0, speeds), (each, k) => Math.abs(each - slopes[0][k])));
        const moved = Float64Array.from(state), rate = new Float64Array(n), rest = new Float64Array(n);
        for (let k = 0; k < speeds; k += 1) moved[k] = state[k] + small * (slopes[1][k] - slopes[0][k]);
        symbody_call(functions.motion, speeds, block, block[at.run.numbers], time, moved, 0, rate, 0);
        symbody_call(functions.motion, speeds, block, block[at.run.numbers], time, state, 0, rest, 0);
        moved.set(state);
        for (let k = speeds; k < n - 1; k += 1) moved[k] += rate[k] - rest[k];
        computePose(moved);
        const there = placeOf(pull.body, pull.point);
        computePose(state);
        const mobility = there.reduce((sum, each, i) => sum + (each - point[i]) * direction[i], 0) / small;
        const most = numbers.pull.mass;
        return mobility > 1 / most ? 1 / mobility : most;
    }

    function applyPull(interval) {
        computePose(state);
        const point = placeOf(pull.body, pull.point);
        const way = point.map((each, i) => pull.target[i] - each);
        const length = Math.hypot(...way);
        if (pull.age % 4 === 0) pull.mass = massAt(point, length > 0 ? way.map((each) => each / length) : [1, 0, 0]);
        pull.age += 1;
        const before = pull.before ?? point, { frequency } = numbers.pull;
        const stiffness = pull.mass * frequency * frequency, damping = 1.4 * pull.mass * frequency;
        const force = way.map((each, i) => stiffness * each - (damping * (point[i] - before[i])) / (pull.interval || interval));
        pull.before = point;
        pull.interval = interval;
        writeWrench(force, point.map((each, i) => each - pose.positions[3 * pull.body + i]));
    }

    function hold(body, point, target) {
        pull = { body, point, target, mass: 0, age: 0, before: null, interval: 0 };
    }

    function release() {
        if (pull === null) return;
        pull = null;
        writeWrench([0, 0, 0], [0, 0, 0]);
    }

    // Change a state, or parameters; bring it onto the constraints, with the states at some places held. Return
    // whether that can be.
    function assemble(x, held, change) {
        if (assembly !== null) symbody_note_followers(functions.assembly, assembly, 0, numbers.startTime, x, 0);
        change();
        if (assembly === null) return true;
        const flags = assembly[at.assembly.asked];
        for (let k = 0; k < n - 1; k += 1) assembly[flags + k] = held.includes(k) ? 1 : 0;
        const ended = symbody_close_state(functions.assembly, assembly, 0, numbers.startTime, x, 0);
        return ended === 0 && x.every(Number.isFinite);
    }

    // Try other parameters: the state shown and the first one follow in steps, or all stays as it is.
    function tryParameters(values, held, parts) {
        const before = Float64Array.from(parameters), now = Float64Array.from(state), start = Float64Array.from(first);
        const take = (k) => {
            for (let i = 0; i < parameters.length; i += 1) parameters[i] = before[i] + ((values[i] - before[i]) * k) / parts;
            writeArguments();
        };
        const follow = (x, places, k) => {
            take(k - 1);
            return assemble(x, places, () => { take(k); });
        };
        const fits = Array.from({ length: parts }, (_, k) => k + 1).every((k) => follow(now, [], k) && follow(start, held, k));
        if (!fits) {
            parameters.set(before);
            writeArguments();
            return false;
        }
        state.set(now);
        first.set(start);
        return true;
    }

    function setParameter(name, value, held = []) {
        const place = numbers.parameters.names.indexOf(name);
        const values = Float64Array.from(parameters);
        values[place] = value;
        const places = held.map((each) => numbers.states.indexOf(each));
        return [1, 12].some((parts) => tryParameters(values, places, parts)) && refresh();
    }

    function setInput(name, value) {
        inputs[numbers.inputs.names.indexOf(name)] = value;
        writeArguments();
    }

    // Start anew with first values by name; those that contradict the one chosen follow it.
    function setInitial(values, chosen) {
        const names = Object.keys(values);
        for (const kept of [names, [chosen]]) {
            for (const parts of [1, 12]) {
                const start = Float64Array.from(first);
                const places = kept.map((name) => numbers.states.indexOf(name));
                const fits = Array.from({ length: parts }, (_, k) => (k + 1) / parts).every((share) => {
                    return assemble(start, places, () => {
                        kept.forEach((name, k) => { start[places[k]] = first[places[k]] + share * (values[name] - first[places[k]]); });
                    });
                });
                if (fits) {
                    first.set(start);
                    reset();
                    return true;
                }
            }
        }
        return false;
    }

    function refresh() {
        interrupt();
        kernels.forgetModes?.(m);
        code = codes.RUNNING;
        return true;
    }

    function reset() {
        time = numbers.startTime;
        state.set(first);
        release();
        block[at.run.first_step] = numbers.firstStep;
        block[at.run["breaks.next"]] = 0;
        refresh();
        for (const name of ["monitor", "held", "jumps", "modes"]) m[name]?.set(numbers[name]);
        if (monitor !== null) makeRoom(numbers.happenedRoom);
        if (held !== null) showHeld(held.subarray(held[at.held.values]));
        writeArguments();
    }

    // Events up to the time shown: which, and when.
    function happenings() {
        const found = [];
        for (let k = 0; monitor !== null && k < monitor[at.monitor.happened]; k += 1) {
            const [place, t] = m.happened.subarray(k * (n + 2));
            if (t <= time && place < numbers.eventCount) found.push({ name: numbers.events[place], t });
        }
        return found;
    }

    // The largest position residual over the size of the mechanism.
    function violation() {
        if (!isProjected) return 0;
        const place = block[at.run.projection], out = place + block[place + at.projection.out];
        symbody_call(
            functions.projection, speeds, block, place + block[place + at.projection.numbers], time, state, 0, block, out);
        let worst = 0;
        for (let k = 0; k < block[place + at.projection.residuals]; k += 1) {
            worst = Math.max(worst, (Math.abs(block[out + k]) / block[place + block[place + at.projection.scales] + k]) * numbers.closed);
        }
        return worst;
    }

    // Kinetic and potential energy, and the work of all that acts from outside or wastes [J].
    function energies() {
        evaluateView(state);
        return { kinetic: shown[view.energies], potential: shown[view.energies + 1], work: state[n - 1] };
    }

    if (monitor !== null) makeRoom(numbers.happenedRoom);
    if (held !== null) showHeld(held.subarray(held[at.held.values]));
    writeArguments();
    return {
        numbers,
        get time() { return time; },
        get code() { return time < settled() ? codes.RUNNING : code; }, // what ends the motion may lie ahead
        get culprit() { return monitor === null ? "" : numbers.events[monitor[at.monitor.culprit] - 1] ?? ""; },
        get happened() { return happenings(); },
        get state() { return state; },
        get first() { return first; },
        get isPulled() { return pull !== null; },
        parameter: (name) => parameters[numbers.parameters.names.indexOf(name)],
        input: (name) => inputs[numbers.inputs.names.indexOf(name)],
        initial: (name) => first[numbers.states.indexOf(name)],
        counts: () => ({ accepted: block[at.run["counts.accepted"]], rejected: block[at.run["counts.rejected"]], evaluations: block[at.run["counts.evaluations"]] }),
        advanceTo, computePose: () => computePose(state), placeOf, hold, release, setParameter, setInput, setInitial, reset,
        moveTarget: (target) => { if (pull !== null) pull.target = target; },
        violation, energies,
    };
}
