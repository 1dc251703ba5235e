const places = @PLACES@;
const values = @VALUES@;
const times = Float64Array.from(@TIMES@);
const header = @HEADER@;

// Computes the motion: code 2 where the end was reached@STOPS@, and rows of time and states.
function simulate() {
    const block = new Float64Array(@SIZE@);
    const t = new Float64Array(@SAMPLES@), x = new Float64Array(@SAMPLES@ * @N@);
    const breaks = new Float64Array(@BREAKS@), pieces = new Float64Array(@PIECES@);
%events     const monitor = Float64Array.from(@MONITOR@);
%events     const names = @EVENTS@;
%events     let happened = new Float64Array(@FIRST_ROOM@ * (@N@ + 2)); // rows: event, time, states before what it sets
%events     monitor[@ROOM_PLACE@] = @FIRST_ROOM@;
%samples     const held = Float64Array.from(@HELD@);
%samples     const sampling = Float64Array.from(@SAMPLING@);
%samples     const recorded = new Float64Array(@RECORDED@);
%jumps     const jumps = Float64Array.from(@JUMPS@);
%implicit     const implicit = Float64Array.from(@IMPLICIT@);
%switching     const modes = Float64Array.from(@MODES@), decided = new Float64Array(@DECIDED@);
    places.forEach((place, k) => { block[place] = values[k]; });
    let code = @BEGIN@;
    for (;;) {
        if (code === @RUNNING@)
            code = @ADVANCE@;
%events         else if (code === @FULL@) { @FORGET@; code = @RUNNING@; }
%events         else if (code === @NO_EVENT_ROOM@) {
%events             const larger = new Float64Array(2 * happened.length);
%events             larger.set(happened);
%events             happened = larger;
%events             monitor[@ROOM_PLACE@] *= 2;
%events             code = @RUNNING@;
%events         }
%samples         else if (code === @NO_SAMPLE_ROOM@) { held[@RECORDED_PLACE@] = 0; code = @RUNNING@; }
%switching         else if (code === @NO_MODE_ROOM@) { @FORGET_ROWS@; code = @RUNNING@; }
        else break;
    }
    const rows = [];
    for (let k = 0; k < block[@COUNT_PLACE@]; k++) rows.push([t[k], ...x.subarray(k * @N@, (k + 1) * @N@)]);
%events     const events = []; // what happened: name, time, states before what it sets
%events     for (let k = 0; k < monitor[@HAPPENED_PLACE@]; k++) {
%events         const [place, time, ...state] = happened.subarray(k * (@N@ + 2), (k + 1) * (@N@ + 2));
%events         if (place < @EVENT_COUNT@) events.push({ name: names[place], t: time, state });
%events     }
%events     const culprit = names[monitor[@CULPRIT_PLACE@] - 1] ?? ""; // the event that ended the motion by a fault
%events     return { code, rows, events, culprit };
%eventless     return { code, rows };
}

if (typeof process !== "undefined" && typeof module !== "undefined" && require.main === module) {
%events     const { code, rows, events, culprit } = simulate();
%eventless     const { code, rows } = simulate();
    console.log([header, ...rows.map((row) => row.join(","))].join("\n"));
%events     for (const { name, t } of events) console.error(`event ${name}: t = ${t}`);
%events     if (culprit) console.error(`${culprit} ended the motion (code ${code})`);
    process.exitCode = @SUCCESS@ ? 0 : 1;
} else if (typeof module !== "undefined") module.exports = { simulate, header };
