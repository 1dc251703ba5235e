static const int places[] = @PLACES@;
static const double values[] = @VALUES@;
static const double times[] = @TIMES@;
%events static const double first_monitor[] = @MONITOR@;
%events static const char *const events[] = @EVENTS@;
%samples static const double first_held[] = @HELD@;
%samples static const double first_sampling[] = @SAMPLING@;
%jumps static const double first_jumps[] = @JUMPS@;
%switching static const double first_modes[] = @MODES@;
%implicit static const double first_implicit[] = @IMPLICIT@;
static double block[@SIZE@], t[@SAMPLES@], x[@SAMPLES@ * @N@], breaks[@BREAKS@], pieces[@PIECES@];
%events static double monitor[@MONITOR_SIZE@], *happened; /* rows: event, time, states before what it sets */
%samples static double held[@HELD_SIZE@], sampling[@SAMPLING_SIZE@], recorded[@RECORDED@];
%jumps static double jumps[@JUMPS_SIZE@];
%switching static double modes[@MODES_SIZE@], decided[@DECIDED@];
%implicit static double implicit[@IMPLICIT_SIZE@];

%events static void make_room(void)
%events {
%events     monitor[@ROOM_PLACE@] = 2.0 * monitor[@ROOM_PLACE@] + @FIRST_ROOM@;
%events     happened = realloc(happened, (size_t)monitor[@ROOM_PLACE@] * (@N@ + 2) * sizeof(double));
%events     if (happened == NULL) exit(1);
%events }
%events 
/* Computes the motion and returns its code: 2 where the end was reached@STOPS@. Samples lie in t and x by rows. */
static int simulate(int *samples)
{
    int k, code;
    for (k = 0; k < @SIZE@; k++) block[k] = 0.0;
    for (k = 0; k < @PLACE_COUNT@; k++) block[places[k]] = values[k];
%events     for (k = 0; k < @MONITOR_SIZE@; k++) monitor[k] = first_monitor[k];
%events     make_room();
%samples     for (k = 0; k < @HELD_SIZE@; k++) held[k] = first_held[k];
%samples     for (k = 0; k < @SAMPLING_SIZE@; k++) sampling[k] = first_sampling[k];
%jumps     for (k = 0; k < @JUMPS_SIZE@; k++) jumps[k] = first_jumps[k];
%switching     for (k = 0; k < @MODES_SIZE@; k++) modes[k] = first_modes[k];
%implicit     for (k = 0; k < @IMPLICIT_SIZE@; k++) implicit[k] = first_implicit[k];
    code = @BEGIN@;
    for (;;) {
        if (code == @RUNNING@)
            code = @ADVANCE@;
%events         else if (code == @FULL@) { @FORGET@; code = @RUNNING@; }
%events         else if (code == @NO_EVENT_ROOM@) { make_room(); code = @RUNNING@; }
%samples         else if (code == @NO_SAMPLE_ROOM@) { held[@RECORDED_PLACE@] = 0.0; code = @RUNNING@; }
%switching         else if (code == @NO_MODE_ROOM@) { @FORGET_ROWS@; code = @RUNNING@; }
        else break;
    }
    *samples = (int)block[@COUNT_PLACE@];
    return code;
}

int main(void)
{
    int k, i, samples, code = simulate(&samples);
    puts(@HEADER@);
    for (k = 0; k < samples; k++) {
        printf("%.17g", t[k]);
        for (i = 0; i < @N@; i++) printf(",%.17g", x[k * @N@ + i]);
        puts("");
    }
%events     for (k = 0; k < (int)monitor[@HAPPENED_PLACE@]; k++) {
%events         const double *row = happened + (size_t)k * (@N@ + 2);
%events         if (row[0] < @EVENT_COUNT@) fprintf(stderr, "event %s: t = %.17g\n", events[(int)row[0]], row[1]);
%events     }
%events     if (monitor[@CULPRIT_PLACE@] > 0.0)
%events         fprintf(stderr, "%s ended the motion (code %d)\n", events[(int)monitor[@CULPRIT_PLACE@] - 1], code);
    return @SUCCESS@ ? 0 : 1;
}
