!> Check that an arithmetic has the range for a deck. The original's machine would have stopped at
!> an overflow, or gone on with a number that stands for none.
module asperity_deck_range
  use asperity_card_deck, only: card_deck, model_cards
  use asperity_decimal, only: decimal_order
  use asperity_kinds, only: real128, real32, real64
  use asperity_problems, only: decimal_text
  implicit none
  private

  public :: check_deck_range

contains

  !> `failure` is allocated when a number of the deck, or its square, leaves the arithmetic's range.
  pure subroutine check_deck_range(arithmetic, deck, failure)
    character(len=*), intent(in) :: arithmetic             !! ibm370, real32, real64 or real128
    type(card_deck), intent(in) :: deck                    !! the checked cards
    character(len=:), allocatable, intent(out) :: failure  !! number of the deck outside the range;
                                                           !! not allocated: none
    integer :: orders, lengths, most, stiff

    select case (arithmetic)
    case ('ibm370')
      orders = 75
    case ('real32')
      orders = range(1.0_real32)
    case ('real64')
      orders = range(1.0_real64)
    case default
      orders = range(1.0_real128)
    end select
    ! Deviation r: the machine was interrupted where a number left its range.
    ! Lengths and ratios are multiplied with each other, and by powers of ten when units change. A
    ! load is a modulus times an area: less than the square of the largest length.
    most = orders / 2 - 2
    lengths = max(largest_order(deck%upper), largest_order(deck%lower), &
                  maxval(decimal_order([deck%lower_width, deck%x_displacement, &
                                        deck%y_displacement])))
    stiff = orders - 4 - 2 * max(0, lengths)
    if (lengths <= most .and. min(smallest_order(deck%upper), smallest_order(deck%lower)) > &
        -most .and. &
        maxval(decimal_order([deck%upper%elastic_modulus, deck%lower%elastic_modulus, &
                              deck%upper%stress_max, deck%lower%stress_max])) <= stiff) return
    failure = 'a number of the deck is out of the range of ' // arithmetic // ', 1E' // &
              decimal_text(orders) // ': expected no length above 1E' // decimal_text(most) // &
              ', no modulus above 1E' // decimal_text(stiff) // ', and no radius or modulus ' // &
              'below 1E-' // decimal_text(most)
  end subroutine check_deck_range

  !> Order of a model's largest number that is multiplied with another such number.
  pure integer function largest_order(model)
    type(model_cards), intent(in) :: model

    largest_order = max(maxval(decimal_order(model%x)), maxval(decimal_order(model%y)), &
                  maxval(decimal_order(model%z)), &
                  maxval(decimal_order([model%radius, model%height_max, model%poisson_ratio, &
                                        model%angle])))
  end function largest_order

  !> Order of the least number that must not become zero.
  pure integer function smallest_order(model)
    type(model_cards), intent(in) :: model

    smallest_order = minval(decimal_order([model%radius, model%elastic_modulus]))
  end function smallest_order

end module asperity_deck_range
