!> The original program in the arithmetic asked for.
module asperity_original
  use asperity_card_deck, only: card_deck
  use asperity_deck_range, only: check_deck_range
  use asperity_original_ibm370, only: run_ibm370 => run_original
  use asperity_original_real128, only: run_real128 => run_original
  use asperity_original_real32, only: run_real32 => run_original
  use asperity_original_real64, only: run_real64 => run_original
  use asperity_original_records, only: original_records, original_request
  implicit none
  private

  public :: arithmetic_names, run_in_arithmetic

  !> The arithmetics by name; the first is the default.
  character(len=7), parameter :: arithmetic_names(4) = &
    [character(len=7) :: 'ibm370', 'real32', 'real64', 'real128']

contains

  !> Runs the original program. `failure` is allocated when the original would have gone astray,
  !> when the deck's numbers are out of the arithmetic's range, or when it is none
  !> of `arithmetic_names`.
  subroutine run_in_arithmetic(arithmetic, deck, request, records, failure)
    character(len=*), intent(in) :: arithmetic             !! one of `arithmetic_names`
    type(card_deck), intent(in) :: deck                    !! the checked cards
    type(original_request), intent(in) :: request          !! what to keep
    type(original_records), intent(out) :: records         !! what it computes
    character(len=:), allocatable, intent(out) :: failure  !! why it had to stop

    call check_deck_range(arithmetic, deck, failure)
    if (allocated(failure)) return
    select case (arithmetic)
    case ('ibm370')
      call run_ibm370(deck, request, records, failure)
    case ('real32')
      call run_real32(deck, request, records, failure)
    case ('real64')
      call run_real64(deck, request, records, failure)
    case ('real128')
      call run_real128(deck, request, records, failure)
    case default
      failure = 'unknown arithmetic ' // arithmetic
    end select
  end subroutine run_in_arithmetic

end module asperity_original
