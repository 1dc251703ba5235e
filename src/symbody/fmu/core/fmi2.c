/* Copyright (c) 2026, The symbody authors. SPDX-License-Identifier: BSD-3-Clause */
/* FMI 2.0: the functions of the standard on `instance.h`. */

#include "fmi2Functions.h"
#include "model.h"
#include "motion.h"
#include "conditions.h"
#include "results.h"
#include "modes.h"
#include "events.h"
#include "samples.h"
#include "steps.h"
#include "instance.h"

#define ANY (INSTANTIATED | INITIALIZATION | EVENT | CONTINUOUS | STEP | TERMINATED)
#define LEGAL(modes) \
    if (!is_legal((Instance *)c, __func__, modes)) return fmi2Error
#define MOTION (&((Instance *)c)->motion)
#define OURS ((Instance *)c)

static void deliver(Instance *instance, int status, const char *category, const char *text)
{
    const fmi2CallbackFunctions *callbacks = (const fmi2CallbackFunctions *)instance->callbacks;
    if (callbacks && callbacks->logger)
        callbacks->logger(callbacks->componentEnvironment, instance->name, (fmi2Status)status, category, "%s", text);
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(
    fmi2Component c, fmi2Boolean loggingOn, size_t nCategories, const fmi2String categories[])
{
    size_t k;
    int events = nCategories == 0;
    LEGAL(ANY);
    for (k = 0; k < nCategories; k++) {
        if (strcmp(categories[k], "logEvents") == 0) events = 1;
        else if (strcmp(categories[k], "logStatusError") != 0)
            return (fmi2Status)fail(OURS, STATUS_ERROR, __func__, "categories are logStatusError and logEvents");
    }
    if (events) OURS->logs_events = loggingOn;
    return fmi2OK;
}

fmi2Component fmi2Instantiate(
    fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID, fmi2String fmuResourceLocation,
    const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean loggingOn)
{
    Instance *made = new_instance(instanceName, fmuType == fmi2CoSimulation ? CO_SIMULATION : MODEL_EXCHANGE, fmuGUID);
    (void)fmuResourceLocation, (void)visible;
    if (made == NULL) {
        if (functions && functions->logger)
            functions->logger(functions->componentEnvironment, instanceName, fmi2Error, "logStatusError",
                "the GUID is not that of this FMU, or memory is exhausted");
        return NULL;
    }
    made->callbacks = functions;
    made->logs_events = loggingOn;
    return made;
}

void fmi2FreeInstance(fmi2Component c) { free_instance(OURS); }

fmi2Status fmi2SetupExperiment(
    fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
    fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    LEGAL(INSTANTIATED);
    enter_initialization(OURS, startTime, stopTimeDefined, stopTime, toleranceDefined ? tolerance : 0.0);
    MOTION->mode = INSTANTIATED;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    LEGAL(INSTANTIATED);
    MOTION->mode = INITIALIZATION;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    LEGAL(INITIALIZATION);
    return (fmi2Status)exit_initialization(OURS, __func__);
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    LEGAL(EVENT | CONTINUOUS | STEP);
    MOTION->mode = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    LEGAL(ANY);
    begin_motion(MOTION);
    MOTION->mode = INSTANTIATED;
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[])
{
    LEGAL(ANY);
    return (fmi2Status)get_values(OURS, __func__, vr, nvr, value);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[])
{
    LEGAL(INSTANTIATED | INITIALIZATION | EVENT | CONTINUOUS | STEP);
    return (fmi2Status)set_values(OURS, __func__, vr, nvr, value);
}

/* Variables of other types do not exist. */
#define NO_TYPE(type) \
    fmi2Status fmi2Get##type(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2##type value[]) \
    { \
        (void)vr, (void)value; \
        LEGAL(ANY); \
        return nvr == 0 ? fmi2OK : (fmi2Status)fail(OURS, STATUS_ERROR, __func__, "all variables are of type Real"); \
    } \
    fmi2Status fmi2Set##type(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2##type value[]) \
    { \
        (void)vr, (void)value; \
        LEGAL(ANY); \
        return nvr == 0 ? fmi2OK : (fmi2Status)fail(OURS, STATUS_ERROR, __func__, "all variables are of type Real"); \
    }
NO_TYPE(Integer)
NO_TYPE(Boolean)
NO_TYPE(String)

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    LEGAL(ANY);
    return (fmi2Status)keep_motion(OURS, __func__, FMUstate);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate)
{
    LEGAL(ANY);
    return (fmi2Status)restore_motion(OURS, __func__, FMUstate);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    (void)c;
    forget_motion(FMUstate);
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size)
{
    (void)FMUstate;
    LEGAL(ANY);
    *size = sizeof(Motion);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[], size_t size)
{
    LEGAL(ANY);
    return (fmi2Status)write_motion(OURS, __func__, FMUstate, serializedState, size);
}

fmi2Status fmi2DeSerializeFMUstate(
    fmi2Component c, const fmi2Byte serializedState[], size_t size, fmi2FMUstate *FMUstate)
{
    LEGAL(ANY);
    return (fmi2Status)read_motion(OURS, __func__, serializedState, size, FMUstate);
}

fmi2Status fmi2GetDirectionalDerivative(
    fmi2Component c, const fmi2ValueReference vUnknown_ref[], size_t nUnknown, const fmi2ValueReference vKnown_ref[],
    size_t nKnown, const fmi2Real dvKnown[], fmi2Real dvUnknown[])
{
    LEGAL(INITIALIZATION | EVENT | CONTINUOUS | STEP | TERMINATED);
    return (fmi2Status)directional_derivative(
        OURS, __func__, vUnknown_ref, nUnknown, vKnown_ref, nKnown, dvKnown, dvUnknown);
}

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    LEGAL(EVENT | CONTINUOUS);
    note_events(MOTION);
    MOTION->mode = EVENT;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *eventInfo)
{
    int has_changed, must_stop;
    double next = HUGE_VAL;
    fmi2Status status;
    LEGAL(EVENT);
    status = (fmi2Status)update(OURS, __func__, &has_changed, &must_stop, &next);
    eventInfo->newDiscreteStatesNeeded = eventInfo->nominalsOfContinuousStatesChanged = fmi2False;
    eventInfo->terminateSimulation = must_stop != 0;
    eventInfo->valuesOfContinuousStatesChanged = has_changed != 0;
    eventInfo->nextEventTimeDefined = next < HUGE_VAL;
    eventInfo->nextEventTime = next < HUGE_VAL ? next : 0.0;
    return status;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    LEGAL(EVENT);
    MOTION->mode = CONTINUOUS;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(
    fmi2Component c, fmi2Boolean noSetFMUStatePriorToCurrentPoint, fmi2Boolean *enterEventMode,
    fmi2Boolean *terminateSimulation)
{
    int enters;
    (void)noSetFMUStatePriorToCurrentPoint;
    LEGAL(CONTINUOUS);
    completed_step(OURS, &enters);
    *enterEventMode = enters != 0;
    *terminateSimulation = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    LEGAL(EVENT | CONTINUOUS);
    MOTION->time = time;
    MOTION->valid = 0;
    return fmi2OK;
}

#define OF_SIZE(count, size) \
    if ((count) != (size)) return (fmi2Status)fail(OURS, STATUS_ERROR, __func__, "the array has a wrong size")

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx)
{
    LEGAL(EVENT | CONTINUOUS);
    OF_SIZE(nx, SB_X);
    set_states(OURS, x);
    return fmi2OK;
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx)
{
    LEGAL(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    OF_SIZE(nx, SB_X);
    return (fmi2Status)get_slope(OURS, __func__, derivatives);
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni)
{
    LEGAL(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    OF_SIZE(ni, SB_WATCHED);
    return (fmi2Status)event_indicators(OURS, __func__, eventIndicators);
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx)
{
    LEGAL(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    OF_SIZE(nx, SB_X);
    return (fmi2Status)get_states(OURS, __func__, x);
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx)
{
    LEGAL(INSTANTIATED | INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    OF_SIZE(nx, SB_X);
    memcpy(x_nominal, sb_nominal, SB_X * sizeof(double));
    return fmi2OK;
}

fmi2Status fmi2SetRealInputDerivatives(
    fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer order[], const fmi2Real value[])
{
    (void)vr, (void)order, (void)value;
    LEGAL(ANY);
    return nvr == 0 ? fmi2OK : (fmi2Status)fail(OURS, STATUS_ERROR, __func__, "inputs are constant during a step");
}

fmi2Status fmi2GetRealOutputDerivatives(
    fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer order[], fmi2Real value[])
{
    (void)vr, (void)order, (void)value;
    LEGAL(ANY);
    return nvr == 0 ? fmi2OK : (fmi2Status)fail(OURS, STATUS_ERROR, __func__, "outputs have no derivatives in time");
}

fmi2Status fmi2DoStep(
    fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
    fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    fmi2Status status;
    (void)noSetFMUStatePriorToCurrentPoint;
    LEGAL(STEP);
    status = (fmi2Status)do_step(
        OURS, __func__, currentCommunicationPoint, communicationStepSize, &MOTION->has_stopped);
    return status == fmi2OK && MOTION->has_stopped ? fmi2Discard : status;
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    LEGAL(STEP);
    return (fmi2Status)fail(OURS, STATUS_ERROR, __func__, "steps are done when fmi2DoStep returns");
}

#define NO_STATUS(name, type) \
    fmi2Status fmi2Get##name(fmi2Component c, const fmi2StatusKind s, type *value) \
    { \
        (void)s, (void)value; \
        LEGAL(ANY); \
        return (fmi2Status)fail(OURS, STATUS_DISCARD, __func__, "steps are done when fmi2DoStep returns"); \
    }
NO_STATUS(Status, fmi2Status)
NO_STATUS(IntegerStatus, fmi2Integer)
NO_STATUS(StringStatus, fmi2String)

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value)
{
    LEGAL(ANY);
    if (s != fmi2LastSuccessfulTime)
        return (fmi2Status)fail(OURS, STATUS_DISCARD, __func__, "there is no such status");
    *value = MOTION->time;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *value)
{
    LEGAL(ANY);
    if (s != fmi2Terminated) return (fmi2Status)fail(OURS, STATUS_DISCARD, __func__, "there is no such status");
    *value = MOTION->has_stopped;
    return fmi2OK;
}
