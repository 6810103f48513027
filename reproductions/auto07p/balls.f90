! An isotropic planar rotor with equal balls in the frame that turns with it, for AUTO-07p.
! Written from Spannan (2021), (4.14)-(4.17), with the balls eliminated, independently of the package.
! U: x, y, vx, vy (velocity in space), ball angles, ball speeds. Lengths in units of LENGTH, time in 1/w_c.
! PAR(1) rotor speed in rad/s, PAR(2) unbalance in kg m, PAR(3) drag of a ball in N m s, PAR(11) period in units of 1/w_c.

MODULE MACHINE
  IMPLICIT NONE
  DOUBLE PRECISION, PARAMETER :: MASS = 10d0, STIFFNESS = 625d3, DAMPING = 100d0
  DOUBLE PRECISION, PARAMETER :: BALL = 2.5d-3, ORBIT = 0.1d0, WC = 250d0, LENGTH = 1d-3
  DOUBLE PRECISION, PARAMETER :: PI2 = 6.283185307179586476925d0
END MODULE MACHINE

SUBROUTINE FUNC(NDIM, U, ICP, PAR, IJAC, F, DFDU, DFDP)
  USE MACHINE
  IMPLICIT NONE
  INTEGER, INTENT(IN) :: NDIM, ICP(*), IJAC
  DOUBLE PRECISION, INTENT(IN) :: U(NDIM), PAR(*)
  DOUBLE PRECISION, INTENT(OUT) :: F(NDIM)
  DOUBLE PRECISION, INTENT(INOUT) :: DFDU(NDIM, NDIM), DFDP(NDIM, *)
  DOUBLE PRECISION :: W, BETA, MOMENT, INERTIA, X, Y, VX, VY, FX, FY, MXX, MXY, MYY, DET, AX, AY, C, S, P, Q, SHARE
  INTEGER :: I, N
  N = (NDIM - 4) / 2
  SHARE = MERGE(2d0, 1d0, N == 1)  ! one ball stands for two that coincide
  W = PAR(1); BETA = SHARE * PAR(3)
  MOMENT = SHARE * BALL * ORBIT; INERTIA = SHARE * 1.4d0 * BALL * ORBIT**2
  X = U(1) * LENGTH; Y = U(2) * LENGTH; VX = U(3) * LENGTH * WC; VY = U(4) * LENGTH * WC
  FX = -STIFFNESS * X - DAMPING * VX + PAR(2) * W**2
  FY = -STIFFNESS * Y - DAMPING * VY
  MXX = MASS; MXY = 0d0; MYY = MASS
  DO I = 1, N
    C = COS(U(4 + I)); S = SIN(U(4 + I)); P = U(4 + N + I) * WC
    Q = MOMENT * BETA * P / INERTIA
    FX = FX + MOMENT * (W + P)**2 * C - Q * S
    FY = FY + MOMENT * (W + P)**2 * S + Q * C
    MXX = MXX - MOMENT**2 / INERTIA * S * S
    MXY = MXY + MOMENT**2 / INERTIA * S * C
    MYY = MYY - MOMENT**2 / INERTIA * C * C
  END DO
  DET = MXX * MYY - MXY**2
  AX = (MYY * FX - MXY * FY) / DET
  AY = (MXX * FY - MXY * FX) / DET
  F(1) = (VX + W * Y) / (LENGTH * WC)
  F(2) = (VY - W * X) / (LENGTH * WC)
  F(3) = (AX + W * VY) / (LENGTH * WC**2)
  F(4) = (AY - W * VX) / (LENGTH * WC**2)
  DO I = 1, N
    C = COS(U(4 + I)); S = SIN(U(4 + I)); P = U(4 + N + I) * WC
    F(4 + I) = U(4 + N + I)
    F(4 + N + I) = (-BETA * P + MOMENT * (S * AX - C * AY)) / INERTIA / WC**2
  END DO
  IF (N == 1) F = PAR(11) * F  ! AUTO does not scale the time of boundary value problems
END SUBROUTINE FUNC

SUBROUTINE STPNT(NDIM, U, PAR, T)
  USE MACHINE
  IMPLICIT NONE
  INTEGER, INTENT(IN) :: NDIM
  DOUBLE PRECISION, INTENT(INOUT) :: U(NDIM), PAR(*)
  DOUBLE PRECISION, INTENT(IN) :: T
  DOUBLE PRECISION :: OPEN
  PAR(1) = 300d0
  IF (NDIM == 6) THEN  ! the stalled orbit; its states come from a file
    PAR(2) = 5d-4; PAR(3) = 1.4685d-4
  ELSE  ! the balanced state
    PAR(2) = 4.25d-4; PAR(3) = 1d-4
    OPEN = ACOS(-PAR(2) / (2d0 * BALL * ORBIT))
    U = 0d0
    U(5) = OPEN; U(6) = -OPEN
  END IF
END SUBROUTINE STPNT

SUBROUTINE BCND(NDIM, PAR, ICP, NBC, U0, U1, FB, IJAC, DBC)
  USE MACHINE
  IMPLICIT NONE
  INTEGER, INTENT(IN) :: NDIM, ICP(*), NBC, IJAC
  DOUBLE PRECISION, INTENT(IN) :: PAR(*), U0(NDIM), U1(NDIM)
  DOUBLE PRECISION, INTENT(OUT) :: FB(NBC)
  DOUBLE PRECISION, INTENT(INOUT) :: DBC(NBC, *)
  FB(1:NDIM) = U1 - U0
  FB(5) = FB(5) + PI2  ! one revolution lost in a period
END SUBROUTINE BCND

SUBROUTINE ICND(NDIM, PAR, ICP, NINT, U, UOLD, UDOT, UPOLD, FI, IJAC, DINT)
  IMPLICIT NONE
  INTEGER, INTENT(IN) :: NDIM, ICP(*), NINT, IJAC
  DOUBLE PRECISION, INTENT(IN) :: PAR(*), U(NDIM), UOLD(NDIM), UDOT(NDIM), UPOLD(NDIM)
  DOUBLE PRECISION, INTENT(OUT) :: FI(NINT)
  DOUBLE PRECISION, INTENT(INOUT) :: DINT(NINT, *)
  FI(1) = DOT_PRODUCT(U - UOLD, UPOLD)
END SUBROUTINE ICND

SUBROUTINE FOPT
END SUBROUTINE FOPT

SUBROUTINE PVLS
END SUBROUTINE PVLS
