/* Behaviors that cannot be used, each for another reason, beside one that can. */
#include "mfront_one.c"

BEHAVIOR(Abaqus, "Abaqus", 2, 3)
BEHAVIOR(SmallStrain, "Generic", 1, 1)
BEHAVIOR(PlaneStrain, "Generic", 2, 3)
BEHAVIOR(Irradiated, "Generic", 2, 3)
unsigned short Irradiated_nExternalStateVariables = 1;
const char *Irradiated_ExternalStateVariables[] = {"Flux"};
int Irradiated_Tridimensional(BehaviourData *d)
{
    return integrate(d);
}

BEHAVIOR(Diverges, "Generic", 2, 3)
int Diverges_Tridimensional(BehaviourData *d)
{
    strcpy(d->error_message, "no convergence after 100 iterations");
    return -1;
}

BEHAVIOR(Shortens, "Generic", 2, 3)
int Shortens_Tridimensional(BehaviourData *d)
{
    *d->rdt = 0.25;
    return -1;
}

BEHAVIOR(Overruns, "Generic", 2, 3)
int Overruns_Tridimensional(BehaviourData *d)
{
    d->s1.internal_state_variables[7] = 1;
    return integrate(d);
}
