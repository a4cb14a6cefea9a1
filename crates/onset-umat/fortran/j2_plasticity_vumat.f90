! Plasticity of von Mises with linear isotropic hardening as an Abaqus VUMAT (compare j2_plasticity.f90): small strains in the
! axes that turn with the rotation R of F = R U. Shear strains are components of the tensor, half of the engineering strains.
!
! props: Young's modulus, Poisson's ratio, yield stress, hardening modulus d(yield stress)/d(equivalent plastic strain).
! state(1): equivalent plastic strain.
!
!   gfortran -shared -fPIC -O2 -o j2_plasticity_vumat.so j2_plasticity_vumat.f90
subroutine vumat(nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal, stepTime, totalTime, dt, cmname, coordMp, charLength, &
                 props, density, strainInc, relSpinInc, tempOld, stretchOld, defgradOld, fieldOld, stressOld, stateOld, &
                 enerInternOld, enerInelasOld, tempNew, stretchNew, defgradNew, fieldNew, stressNew, stateNew, enerInternNew, &
                 enerInelasNew)
  implicit none
  integer, intent(in) :: nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal
  character(len=80), intent(in) :: cmname
  double precision, intent(in) :: stepTime, totalTime, dt, coordMp(nblock, *), charLength(nblock), props(nprops)
  double precision, intent(in) :: density(nblock), strainInc(nblock, ndir + nshr), relSpinInc(nblock, nshr), tempOld(nblock)
  double precision, intent(in) :: stretchOld(nblock, ndir + nshr), defgradOld(nblock, ndir + 2*nshr), fieldOld(nblock, nfieldv)
  double precision, intent(in) :: stressOld(nblock, ndir + nshr), stateOld(nblock, nstatev), enerInternOld(nblock)
  double precision, intent(in) :: enerInelasOld(nblock), tempNew(nblock), stretchNew(nblock, ndir + nshr)
  double precision, intent(in) :: defgradNew(nblock, ndir + 2*nshr), fieldNew(nblock, nfieldv)
  double precision, intent(out) :: stressNew(nblock, ndir + nshr), stateNew(nblock, nstatev), enerInternNew(nblock)
  double precision, intent(out) :: enerInelasNew(nblock)
  double precision :: shear, bulk, hardening, yield, pressure, trial, increment, deviator(6), work
  integer :: k

  shear = props(1)/(2.0d0*(1.0d0 + props(2)))
  bulk = props(1)/(3.0d0*(1.0d0 - 2.0d0*props(2)))
  hardening = props(4)
  do k = 1, nblock
    pressure = sum(stressOld(k, 1:3))/3.0d0 + bulk*sum(strainInc(k, 1:3))
    deviator = stressOld(k, :) + 2.0d0*shear*strainInc(k, :)
    deviator(1:3) = deviator(1:3) - sum(deviator(1:3))/3.0d0
    trial = sqrt(1.5d0*(sum(deviator(1:3)**2) + 2.0d0*sum(deviator(4:6)**2)))
    yield = props(3) + hardening*stateOld(k, 1)
    increment = 0.0d0
    if (trial > yield) then
      increment = (trial - yield)/(3.0d0*shear + hardening)
      deviator = deviator*(1.0d0 - 3.0d0*shear*increment/trial)
    end if
    stateNew(k, 1) = stateOld(k, 1) + increment
    stressNew(k, :) = deviator
    stressNew(k, 1:3) = stressNew(k, 1:3) + pressure
    work = 0.5d0*dot_product(stressOld(k, 1:3) + stressNew(k, 1:3), strainInc(k, 1:3)) &
           + dot_product(stressOld(k, 4:6) + stressNew(k, 4:6), strainInc(k, 4:6))
    enerInternNew(k) = enerInternOld(k) + work/density(k)
    enerInelasNew(k) = enerInelasOld(k) + increment*(yield + 0.5d0*hardening*increment)/density(k)
  end do
end subroutine vumat
