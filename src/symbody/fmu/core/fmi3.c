/* Copyright (c) 2026, The symbody authors. SPDX-License-Identifier: BSD-3-Clause */
/* FMI 3.0: the functions of the standard on `instance.h`. */

#include "fmi3Functions.h"
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
    if (!is_legal((Instance *)instance, __func__, modes)) return fmi3Error
#define MOTION (&((Instance *)instance)->motion)
#define OURS ((Instance *)instance)

static void deliver(Instance *instance, int status, const char *category, const char *text)
{
    fmi3LogMessageCallback logger = (fmi3LogMessageCallback)instance->logger;
    if (logger) logger(instance->environment, (fmi3Status)status, category, text);
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(
    fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories, const fmi3String categories[])
{
    size_t k;
    int events = nCategories == 0;
    LEGAL(ANY);
    for (k = 0; k < nCategories; k++) {
        if (strcmp(categories[k], "logEvents") == 0) events = 1;
        else if (strcmp(categories[k], "logStatusError") != 0)
            return (fmi3Status)fail(OURS, STATUS_ERROR, __func__, "categories are logStatusError and logEvents");
    }
    if (events) OURS->logs_events = loggingOn;
    return fmi3OK;
}

static fmi3Instance instantiate(
    int kind, fmi3String name, fmi3String token, fmi3Boolean loggingOn, fmi3InstanceEnvironment environment,
    fmi3LogMessageCallback logMessage)
{
    Instance *made = new_instance(name, kind, token);
    if (made == NULL) {
        if (logMessage)
            logMessage(environment, fmi3Error, "logStatusError",
                "the instantiation token is not that of this FMU, or memory is exhausted");
        return NULL;
    }
    made->environment = environment;
    made->logger = (void (*)(void))logMessage;
    made->logs_events = loggingOn;
    return made;
}

fmi3Instance fmi3InstantiateModelExchange(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath, fmi3Boolean visible,
    fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage)
{
    (void)resourcePath, (void)visible;
    return instantiate(MODEL_EXCHANGE, instanceName, instantiationToken, loggingOn, instanceEnvironment, logMessage);
}

fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath, fmi3Boolean visible,
    fmi3Boolean loggingOn, fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
    const fmi3ValueReference requiredIntermediateVariables[], size_t nRequiredIntermediateVariables,
    fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
    fmi3IntermediateUpdateCallback intermediateUpdate)
{
    (void)resourcePath, (void)visible, (void)eventModeUsed, (void)earlyReturnAllowed;
    (void)requiredIntermediateVariables, (void)nRequiredIntermediateVariables, (void)intermediateUpdate;
    return instantiate(CO_SIMULATION, instanceName, instantiationToken, loggingOn, instanceEnvironment, logMessage);
}

fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath, fmi3Boolean visible,
    fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
    fmi3ClockUpdateCallback clockUpdate, fmi3LockPreemptionCallback lockPreemption,
    fmi3UnlockPreemptionCallback unlockPreemption)
{
    (void)instanceName, (void)instantiationToken, (void)resourcePath, (void)visible, (void)loggingOn;
    (void)clockUpdate, (void)lockPreemption, (void)unlockPreemption;
    if (logMessage)
        logMessage(instanceEnvironment, fmi3Error, "logStatusError", "this FMU has no scheduled execution");
    return NULL;
}

void fmi3FreeInstance(fmi3Instance instance) { free_instance(OURS); }

fmi3Status fmi3EnterInitializationMode(
    fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance, fmi3Float64 startTime,
    fmi3Boolean stopTimeDefined, fmi3Float64 stopTime)
{
    LEGAL(INSTANTIATED);
    return (fmi3Status)enter_initialization(
        OURS, startTime, stopTimeDefined, stopTime, toleranceDefined ? tolerance : 0.0);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    LEGAL(INITIALIZATION);
    return (fmi3Status)exit_initialization(OURS, __func__);
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    LEGAL(CONTINUOUS);
    note_events(MOTION);
    MOTION->mode = EVENT;
    return fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    LEGAL(EVENT | CONTINUOUS | STEP);
    MOTION->mode = TERMINATED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    LEGAL(ANY);
    begin_motion(MOTION);
    MOTION->mode = INSTANTIATED;
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(
    fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
    fmi3Float64 values[], size_t nValues)
{
    LEGAL(ANY);
    if (nValues != nValueReferences) return (fmi3Status)fail(OURS, STATUS_ERROR, __func__, "all variables are scalar");
    return (fmi3Status)get_values(OURS, __func__, valueReferences, nValueReferences, values);
}

fmi3Status fmi3SetFloat64(
    fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
    const fmi3Float64 values[], size_t nValues)
{
    LEGAL(INSTANTIATED | INITIALIZATION | EVENT | CONTINUOUS | STEP);
    if (nValues != nValueReferences) return (fmi3Status)fail(OURS, STATUS_ERROR, __func__, "all variables are scalar");
    return (fmi3Status)set_values(OURS, __func__, valueReferences, nValueReferences, values);
}

/* Variables of other types do not exist. */
#define NO_VARIABLES(parameters) \
    parameters \
    { \
        LEGAL(ANY); \
        return nValueReferences == 0 ? fmi3OK \
            : (fmi3Status)fail(OURS, STATUS_ERROR, __func__, "all variables are of type Float64"); \
    }
#define NO_TYPE(type) \
    NO_VARIABLES(fmi3Status fmi3Get##type( \
        fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, \
        fmi3##type values[], size_t nValues)) \
    NO_VARIABLES(fmi3Status fmi3Set##type( \
        fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, \
        const fmi3##type values[], size_t nValues))
NO_TYPE(Float32)
NO_TYPE(Int8)
NO_TYPE(UInt8)
NO_TYPE(Int16)
NO_TYPE(UInt16)
NO_TYPE(Int32)
NO_TYPE(UInt32)
NO_TYPE(Int64)
NO_TYPE(UInt64)
NO_TYPE(Boolean)
NO_TYPE(String)
#define REFERENCES fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences
NO_VARIABLES(fmi3Status fmi3GetBinary(REFERENCES, size_t valueSizes[], fmi3Binary values[], size_t nValues))
NO_VARIABLES(fmi3Status fmi3SetBinary(REFERENCES, const size_t valueSizes[], const fmi3Binary values[], size_t nValues))
NO_VARIABLES(fmi3Status fmi3GetClock(REFERENCES, fmi3Clock values[]))
NO_VARIABLES(fmi3Status fmi3SetClock(REFERENCES, const fmi3Clock values[]))
NO_VARIABLES(fmi3Status fmi3GetIntervalDecimal(REFERENCES, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[]))
NO_VARIABLES(fmi3Status fmi3GetIntervalFraction(
    REFERENCES, fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[]))
NO_VARIABLES(fmi3Status fmi3GetShiftDecimal(REFERENCES, fmi3Float64 shifts[]))
NO_VARIABLES(fmi3Status fmi3GetShiftFraction(REFERENCES, fmi3UInt64 counters[], fmi3UInt64 resolutions[]))
NO_VARIABLES(fmi3Status fmi3SetIntervalDecimal(REFERENCES, const fmi3Float64 intervals[]))
NO_VARIABLES(fmi3Status fmi3SetIntervalFraction(REFERENCES, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]))
NO_VARIABLES(fmi3Status fmi3SetShiftDecimal(REFERENCES, const fmi3Float64 shifts[]))
NO_VARIABLES(fmi3Status fmi3SetShiftFraction(REFERENCES, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]))
NO_VARIABLES(fmi3Status fmi3GetOutputDerivatives(REFERENCES, const fmi3Int32 orders[], fmi3Float64 values[], size_t nValues))

#define ABSENT(declaration, what) \
    declaration \
    { \
        LEGAL(ANY); \
        return (fmi3Status)fail(OURS, STATUS_ERROR, __func__, what); \
    }
ABSENT(fmi3Status fmi3GetNumberOfVariableDependencies(
    fmi3Instance instance, fmi3ValueReference valueReference, size_t *nDependencies),
    "dependencies do not change: they stand in modelDescription.xml")
ABSENT(fmi3Status fmi3GetVariableDependencies(
    fmi3Instance instance, fmi3ValueReference dependent, size_t elementIndicesOfDependent[],
    fmi3ValueReference independents[], size_t elementIndicesOfIndependents[], fmi3DependencyKind dependencyKinds[],
    size_t nDependencies), "dependencies do not change: they stand in modelDescription.xml")
ABSENT(fmi3Status fmi3GetAdjointDerivative(
    fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns, const fmi3ValueReference knowns[],
    size_t nKnowns, const fmi3Float64 seed[], size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity),
    "this FMU has directional derivatives only")
ABSENT(fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance), "there are no structural parameters")
ABSENT(fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance), "there are no structural parameters")
ABSENT(fmi3Status fmi3EnterStepMode(fmi3Instance instance), "co-simulation of this FMU has no event mode")
ABSENT(fmi3Status fmi3ActivateModelPartition(
    fmi3Instance instance, fmi3ValueReference clockReference, fmi3Float64 activationTime),
    "this FMU has no scheduled execution")

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    LEGAL(ANY);
    return (fmi3Status)keep_motion(OURS, __func__, FMUState);
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState)
{
    LEGAL(ANY);
    return (fmi3Status)restore_motion(OURS, __func__, FMUState);
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    (void)instance;
    forget_motion(FMUState);
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState, size_t *size)
{
    (void)FMUState;
    LEGAL(ANY);
    *size = sizeof(Motion);
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(
    fmi3Instance instance, fmi3FMUState FMUState, fmi3Byte serializedState[], size_t size)
{
    LEGAL(ANY);
    return (fmi3Status)write_motion(OURS, __func__, FMUState, serializedState, size);
}

fmi3Status fmi3DeserializeFMUState(
    fmi3Instance instance, const fmi3Byte serializedState[], size_t size, fmi3FMUState *FMUState)
{
    LEGAL(ANY);
    return (fmi3Status)read_motion(OURS, __func__, serializedState, size, FMUState);
}

fmi3Status fmi3GetDirectionalDerivative(
    fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns, const fmi3ValueReference knowns[],
    size_t nKnowns, const fmi3Float64 seed[], size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
{
    LEGAL(INITIALIZATION | EVENT | CONTINUOUS | STEP | TERMINATED);
    if (nSeed != nKnowns || nSensitivity != nUnknowns)
        return (fmi3Status)fail(OURS, STATUS_ERROR, __func__, "all variables are scalar: one seed for each known");
    return (fmi3Status)directional_derivative(
        OURS, __func__, unknowns, nUnknowns, knowns, nKnowns, seed, sensitivity);
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance)
{
    LEGAL(INITIALIZATION | EVENT);
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(
    fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate, fmi3Boolean *terminateSimulation,
    fmi3Boolean *nominalsOfContinuousStatesChanged, fmi3Boolean *valuesOfContinuousStatesChanged,
    fmi3Boolean *nextEventTimeDefined, fmi3Float64 *nextEventTime)
{
    int has_changed, must_stop;
    double next = HUGE_VAL;
    fmi3Status status;
    LEGAL(EVENT);
    status = (fmi3Status)update(OURS, __func__, &has_changed, &must_stop, &next);
    *discreteStatesNeedUpdate = *nominalsOfContinuousStatesChanged = fmi3False;
    *terminateSimulation = must_stop != 0;
    *valuesOfContinuousStatesChanged = has_changed != 0;
    *nextEventTimeDefined = next < HUGE_VAL;
    *nextEventTime = next < HUGE_VAL ? next : 0.0;
    return status;
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance)
{
    LEGAL(EVENT);
    MOTION->mode = CONTINUOUS;
    return fmi3OK;
}

fmi3Status fmi3CompletedIntegratorStep(
    fmi3Instance instance, fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *enterEventMode,
    fmi3Boolean *terminateSimulation)
{
    int enters;
    (void)noSetFMUStatePriorToCurrentPoint;
    LEGAL(CONTINUOUS);
    completed_step(OURS, &enters);
    *enterEventMode = enters != 0;
    *terminateSimulation = fmi3False;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    LEGAL(EVENT | CONTINUOUS);
    MOTION->time = time;
    MOTION->valid = 0;
    return fmi3OK;
}

#define OF_SIZE(count, size) \
    if ((count) != (size)) return (fmi3Status)fail(OURS, STATUS_ERROR, __func__, "the array has a wrong size")

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 continuousStates[], size_t nContinuousStates)
{
    LEGAL(CONTINUOUS);
    OF_SIZE(nContinuousStates, SB_X);
    set_states(OURS, continuousStates);
    return fmi3OK;
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[], size_t nContinuousStates)
{
    LEGAL(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    OF_SIZE(nContinuousStates, SB_X);
    return (fmi3Status)get_slope(OURS, __func__, derivatives);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 eventIndicators[], size_t nEventIndicators)
{
    LEGAL(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    OF_SIZE(nEventIndicators, SB_WATCHED);
    return (fmi3Status)event_indicators(OURS, __func__, eventIndicators);
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 continuousStates[], size_t nContinuousStates)
{
    LEGAL(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    OF_SIZE(nContinuousStates, SB_X);
    return (fmi3Status)get_states(OURS, __func__, continuousStates);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t nContinuousStates)
{
    LEGAL(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    OF_SIZE(nContinuousStates, SB_X);
    memcpy(nominals, sb_nominal, SB_X * sizeof(double));
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *nEventIndicators)
{
    LEGAL(ANY);
    *nEventIndicators = SB_WATCHED;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *nContinuousStates)
{
    LEGAL(ANY);
    *nContinuousStates = SB_X;
    return fmi3OK;
}

fmi3Status fmi3DoStep(
    fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
    fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminateSimulation,
    fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime)
{
    int must_stop;
    fmi3Status status;
    (void)noSetFMUStatePriorToCurrentPoint;
    LEGAL(STEP);
    status = (fmi3Status)do_step(OURS, __func__, currentCommunicationPoint, communicationStepSize, &must_stop);
    *eventHandlingNeeded = *earlyReturn = fmi3False;
    *terminateSimulation = must_stop != 0;
    *lastSuccessfulTime = MOTION->time;
    return status;
}
